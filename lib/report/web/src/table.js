// Sorting, filtering and export of the table of objects.
export function createTable(selection) {
  const table = document.querySelector('table.objects')
  if (!table) return
  const body = table.tBodies[0]
  const rows = [...body.rows]
  const heads = [...table.querySelectorAll('tr.columns th')]
  const byId = new Map(rows.map((row) => [row.dataset.id, row]))

  sortable(table, body, rows, heads)
  filterable(rows, heads)

  for (const row of rows) {
    row.addEventListener('pointerenter', () => selection.hover(row.dataset.id))
    row.addEventListener('pointerleave', () => selection.hover(null))
    row.addEventListener('click', (event) => {
      if (!event.target.closest('a')) selection.select(row.dataset.id, { reveal: true })
    })
  }
  let hovered = null
  let selected = null
  selection.onHover((id) => {
    hovered?.classList.remove('hovered')
    hovered = byId.get(id)
    hovered?.classList.add('hovered')
  })
  selection.onSelect((id) => {
    selected?.classList.remove('selected')
    selected = byId.get(id)
    selected?.classList.add('selected')
  })
}

const GRADES = ['measured', 'bounded', 'screening', 'not_measurable', 'not_cut']

function sortKey(row, column, key) {
  if (key === 'grade') return GRADES.indexOf(row.dataset.grade) < 0 ? null : GRADES.indexOf(row.dataset.grade)
  const cell = row.children[column]
  if (cell.classList.contains('n')) return cell.dataset.v === undefined ? null : Number(cell.dataset.v)
  return cell.textContent
}

function sortable(table, body, rows, heads) {
  let current = null
  let direction = 1
  heads.forEach((head, column) => {
    const button = document.createElement('button')
    button.type = 'button'
    button.append(...head.childNodes)
    head.append(button)
    button.addEventListener('click', () => {
      direction = current === head ? -direction : 1
      current?.removeAttribute('aria-sort')
      current = head
      head.setAttribute('aria-sort', direction > 0 ? 'ascending' : 'descending')
      const keyed = rows.map((row, index) => ({ row, index, key: sortKey(row, column, head.dataset.key) }))
      keyed.sort((a, b) => {
        // Blanks stay last in both directions.
        if (a.key === null || b.key === null) return (a.key === null) - (b.key === null) || a.index - b.index
        const order = typeof a.key === 'number' ? a.key - b.key : a.key.localeCompare(b.key)
        return direction * order || a.index - b.index
      })
      body.append(...keyed.map(({ row }) => row))
    })
  })
}

function filterable(rows, heads) {
  const tools = document.querySelector('.table-tools')
  const shown = document.createElement('output')
  const filters = ['class', 'state', 'grade'].map((name) => {
    const values = [...new Set(rows.map((row) => row.dataset[name]).filter(Boolean))]
    values.sort((a, b) => (name === 'grade' ? GRADES.indexOf(a) - GRADES.indexOf(b) : a.localeCompare(b)))
    const select = document.createElement('select')
    select.setAttribute('aria-label', `Show one ${name}`)
    select.append(new Option(name === 'class' ? 'all classes' : `all ${name}s`, ''))
    for (const value of values) select.append(new Option(value.replaceAll('_', ' '), value))
    select.hidden = values.length < 2
    select.addEventListener('change', apply)
    return { name, select }
  })
  const wanted = document.createElement('input')
  wanted.type = 'search'
  wanted.placeholder = 'id'
  wanted.setAttribute('aria-label', 'Show ids that begin with')
  wanted.addEventListener('input', apply)

  function apply() {
    let count = 0
    for (const row of rows) {
      const fits =
        filters.every(({ name, select }) => !select.value || row.dataset[name] === select.value) &&
        row.dataset.id.startsWith(wanted.value.trim())
      row.hidden = !fits
      count += fits ? 1 : 0
    }
    shown.textContent = count === rows.length ? '' : `${count} of ${rows.length}`
  }

  const save = document.createElement('button')
  save.type = 'button'
  save.textContent = 'Save CSV'
  save.title = 'The rows shown, with all digits'
  save.addEventListener('click', () => download(rows, heads))
  tools.append(shown, wanted, ...filters.map(({ select }) => select), save)
  tools.hidden = false
}

// Cells that a spreadsheet would run as a formula are quoted with an apostrophe.
export function csvCell(text) {
  const safe = /^[=+\-@\t\r]/.test(text) && !/^[+-]?[\d.]+(e[+-]?\d+)?$/i.test(text) ? `'${text}` : text
  return /[",\n\r]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe
}

function download(rows, heads) {
  const keys = heads.map((head) => head.dataset.key)
  const lines = [keys.map(csvCell).join(',')]
  for (const row of rows) {
    if (row.hidden) continue
    const cells = keys.map((key, i) => {
      if (key === 'class' || key === 'state' || key === 'grade') return row.dataset[key]
      return row.children[i].dataset.v ?? ''
    })
    lines.push(cells.map(csvCell).join(','))
  }
  const link = document.createElement('a')
  link.href = URL.createObjectURL(new Blob([lines.join('\n') + '\n'], { type: 'text/csv' }))
  link.download = 'objects.csv'
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 10000)
}
