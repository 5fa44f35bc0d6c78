// Pan and zoom by the SVG's viewBox, which is in metres (x = east, y = -north).
import { openGrid } from './data.js'
import { degreesEast, degreesNorth, fixed, metres, niceFloor } from './format.js'
import { createFrame } from './geodesy.js'

const WHEEL_STEP = 0.0016
const LABELS_BELOW = 0.055 // metres a pixel: closer in, every object shows its number

export function createMap(figure, data, selection) {
  const frame = figure.querySelector('.map-frame')
  const svg = figure.querySelector('.map-svg')
  const start = svg.viewBox.baseVal
  const whole = { x: start.x, y: start.y, w: start.width, h: start.height }
  let view = { ...whole }
  let pending = false

  function fitted(box) {
    // The view takes the frame's aspect, so that metres a pixel are equal in both directions.
    const aspect = frame.clientWidth / Math.max(1, frame.clientHeight)
    const w = Math.max(box.w, box.h * aspect)
    const h = w / aspect
    return { x: box.x + (box.w - w) / 2, y: box.y + (box.h - h) / 2, w, h }
  }
  const unit = () => view.w / Math.max(1, frame.clientWidth)

  function draw() {
    pending = false
    svg.setAttribute('viewBox', `${view.x} ${view.y} ${view.w} ${view.h}`)
    svg.style.setProperty('--k', unit())
    svg.classList.toggle('labelled', unit() < LABELS_BELOW)
    const bar = figure.querySelector('.scalebar')
    const length = niceFloor(unit() * 130)
    bar.querySelector('i').style.width = `${length / unit()}px`
    bar.querySelector('span').textContent = metres(length)
  }
  function update(next) {
    const limit = 4 * Math.max(whole.w, whole.h)
    const w = Math.min(limit, Math.max(0.5, next.w))
    const h = (w / next.w) * next.h
    const cx = Math.min(whole.x + whole.w, Math.max(whole.x, next.x + next.w / 2))
    const cy = Math.min(whole.y + whole.h, Math.max(whole.y, next.y + next.h / 2))
    view = { x: cx - w / 2, y: cy - h / 2, w, h }
    if (!pending) {
      pending = true
      requestAnimationFrame(draw)
    }
  }
  function place(event) {
    const box = svg.getBoundingClientRect()
    return {
      x: view.x + ((event.clientX - box.left) / box.width) * view.w,
      y: view.y + ((event.clientY - box.top) / box.height) * view.h,
    }
  }
  function zoomAt(point, factor) {
    const w = view.w * factor
    if (w < 0.5 || w > 4 * Math.max(whole.w, whole.h)) return
    const x = point.x - (point.x - view.x) * factor
    const y = point.y - (point.y - view.y) * factor
    update({ x, y, w, h: view.h * factor })
  }
  const middle = () => ({ x: view.x + view.w / 2, y: view.y + view.h / 2 })

  // Pointers: one pans, two pinch.
  const pointers = new Map()
  let moved = false
  svg.addEventListener('pointerdown', (event) => {
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY })
    moved = false
  })
  window.addEventListener('pointermove', (event) => {
    const last = pointers.get(event.pointerId)
    if (!last) return
    const now = { x: event.clientX, y: event.clientY }
    if (Math.hypot(now.x - last.x, now.y - last.y) > 3) moved = true
    if (!moved) return
    if (pointers.size === 1) {
      update({ ...view, x: view.x - (now.x - last.x) * unit(), y: view.y - (now.y - last.y) * unit() })
      svg.classList.add('panning')
    } else {
      const other = [...pointers.entries()].find(([id]) => id !== event.pointerId)[1]
      const before = Math.hypot(last.x - other.x, last.y - other.y)
      const after = Math.hypot(now.x - other.x, now.y - other.y)
      if (after > 0) zoomAt(place({ clientX: (now.x + other.x) / 2, clientY: (now.y + other.y) / 2 }), before / after)
    }
    pointers.set(event.pointerId, now)
  })
  const release = (event) => {
    pointers.delete(event.pointerId)
    svg.classList.remove('panning')
  }
  window.addEventListener('pointerup', release)
  window.addEventListener('pointercancel', release)
  svg.addEventListener('click', (event) => {
    if (moved) {
      event.preventDefault()
      event.stopPropagation()
    }
  }, true)
  svg.addEventListener('dragstart', (event) => event.preventDefault())
  svg.addEventListener('wheel', (event) => {
    event.preventDefault()
    zoomAt(place(event), Math.exp(event.deltaY * WHEEL_STEP * (event.deltaMode === 1 ? 18 : 1)))
  }, { passive: false })
  svg.addEventListener('dblclick', (event) => {
    event.preventDefault()
    zoomAt(place(event), 0.5)
  })

  const actions = {
    in: () => zoomAt(middle(), 0.6),
    out: () => zoomAt(middle(), 1 / 0.6),
    all: () => update(fitted(whole)),
  }
  for (const button of figure.querySelectorAll('[data-zoom]'))
    button.addEventListener('click', actions[button.dataset.zoom])
  for (const part of figure.querySelectorAll('.zoom, .scalebar')) part.hidden = false

  svg.tabIndex = 0
  svg.addEventListener('keydown', (event) => {
    const step = view.w * 0.12
    const moves = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }
    if (moves[event.key]) update({ ...view, x: view.x + moves[event.key][0], y: view.y + moves[event.key][1] })
    else if (event.key === '+' || event.key === '=') actions.in()
    else if (event.key === '-') actions.out()
    else if (event.key === '0') actions.all()
    else return
    event.preventDefault()
  })

  readOut(figure, data, svg, place)
  const targets = linkTargets(svg, selection)

  selection.onSelect((id, how) => {
    const target = targets.get(id)
    if (!target || !how.reveal) return
    const { e, f } = target.transform.baseVal.consolidate().matrix
    const w = Math.min(view.w, 30)
    update(fitted({ x: e - w / 2, y: f - w / 2, w, h: w * 0.1 }))
  })

  new ResizeObserver(() => update(fitted({ x: view.x, y: view.y, w: view.w, h: view.h * 0.999 }))).observe(frame)
  update(fitted(whole))
  return {
    goTo(east, north, gap) {
      for (const path of svg.querySelectorAll('.gap')) path.classList.toggle('selected', path.dataset.gap === gap)
      const w = Math.min(view.w, 40)
      update(fitted({ x: east - w / 2, y: -north - w / 2, w, h: w * 0.1 }))
    },
  }
}

// Hover and selection of the objects' symbols.
function linkTargets(svg, selection) {
  const targets = new Map([...svg.querySelectorAll('.target')].map((node) => [node.dataset.id, node]))
  for (const [id, node] of targets) {
    node.addEventListener('pointerenter', () => selection.hover(id))
    node.addEventListener('pointerleave', () => selection.hover(null))
  }
  let hovered = null
  let selected = null
  selection.onHover((id) => {
    hovered?.classList.remove('hovered')
    hovered = targets.get(id) ?? null
    hovered?.classList.add('hovered')
  })
  selection.onSelect((id) => {
    selected?.classList.remove('selected')
    selected = targets.get(id) ?? null
    selected?.classList.add('selected')
    selected?.parentNode.append(selected) // drawn last, above the others
  })
  return targets
}

// Coordinates and raster values under the pointer.
function readOut(figure, data, svg, place) {
  const output = figure.querySelector('.cursor')
  const geodetic = createFrame(data.origin)
  const readers = []
  for (const grid of data.grids) openGrid(grid).then((read) => readers.push({ grid, read }))
  const line = (text) => {
    const span = document.createElement('span')
    span.textContent = text
    return span
  }
  svg.addEventListener('pointermove', (event) => {
    const p = place(event)
    const [east, north] = [p.x, -p.y]
    const values = readers
      .sort((a, b) => data.grids.indexOf(a.grid) - data.grids.indexOf(b.grid))
      .map(({ grid, read }) => ({ grid, value: read(east, north) }))
      .filter(({ value }) => Number.isFinite(value))
    const height = values.find(({ grid }) => grid.name === 'height')?.value
    const up = height === undefined ? 0 : height - data.origin[2]
    const [latitude, longitude] = geodetic(east, north, up)
    const texts = [
      `E\u202f${fixed(east, 2)}  N\u202f${fixed(north, 2)}\u202fm`,
      `${degreesNorth(latitude)}, ${degreesEast(longitude)}`,
    ]
    for (const { grid, value } of values) {
      if (grid.name === 'height') texts.push(`height ${fixed(value, 2)}\u202fm`)
      else if (grid.name === 'views') texts.push(`${Math.round(value)} views`)
      else texts.push(`${grid.name} ${fixed(value, 1)}`)
    }
    output.replaceChildren(...texts.map(line))
  })
  svg.addEventListener('pointerleave', () => output.replaceChildren())
}
