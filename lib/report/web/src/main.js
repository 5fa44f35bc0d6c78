// The page is complete without this script. It adds pan and zoom, selection, sorting and the 3-D views.
import { readData } from './data.js'
import { createSelection } from './selection.js'
import { createMap } from './map_view.js'
import { createTable } from './table.js'
import { createRockView } from './rock_view.js'
import { enhanceCharts } from './polar_readout.js'

const root = document.documentElement
const errors = []
window.addEventListener('error', (event) => {
  errors.push(String(event.message))
  root.dataset.errors = errors.join(' | ')
})
window.addEventListener('unhandledrejection', (event) => {
  errors.push(String(event.reason))
  root.dataset.errors = errors.join(' | ')
})

function start() {
  const data = readData()
  const selection = createSelection()
  const map = createMap(document.getElementById('map'), data, selection)
  createTable(selection)
  const rockView = createRockView(data)
  enhanceCharts(data)
  showSelected(selection, rockView)
  linkPlaces(map, selection)
  followAddress(selection)
  root.dataset.ready = 'true'
}

// One object's article at a time beside the map.
function showSelected(selection, rockView) {
  const panel = document.getElementById('panel')
  const empty = panel.querySelector('.panel-empty')
  selection.onSelect((id) => {
    panel.querySelector('.object.selected')?.classList.remove('selected')
    const article = id === null ? null : document.getElementById(`object-${id}`)
    empty.hidden = Boolean(article)
    if (!article) return
    article.classList.add('selected')
    panel.scrollTop = 0
    rockView.show(article.querySelector('.scene'))
  })
}

// Links to objects select them; rows of other tables point at the map.
function linkPlaces(map, selection) {
  document.addEventListener('click', (event) => {
    const link = event.target.closest('a[href^="#object-"]')
    if (link) {
      event.preventDefault()
      selection.select(link.getAttribute('href').slice('#object-'.length), { reveal: !link.closest('svg') })
      return
    }
    const gap = event.target.closest('tr[data-gap]')
    if (gap) {
      document.getElementById('o-gaps')?.setAttribute('checked', '')
      const box = document.getElementById('o-gaps')
      if (box) box.checked = true
      map.goTo(Number(gap.dataset.e), Number(gap.dataset.n), gap.dataset.gap)
      reveal()
    }
    const obstacle = event.target.closest('#ground tr[data-id]')
    if (obstacle) selection.select(obstacle.dataset.id, { reveal: true })
  })
  selection.onSelect((id, how) => how?.reveal && reveal())
}

function reveal() {
  const box = document.getElementById('explore').getBoundingClientRect()
  if (box.top < -40 || box.top > window.innerHeight * 0.5) {
    const calm = window.matchMedia('(prefers-reduced-motion: reduce)').matches
    document.getElementById('explore').scrollIntoView({ behavior: calm ? 'auto' : 'smooth', block: 'start' })
  }
}

// #object-12 opens object 12; else the rock with the least tipping angle, else the first object.
function followAddress(selection) {
  const wanted = /^#object-(\d+)$/.exec(window.location.hash)?.[1]
  const rows = [...document.querySelectorAll('table.objects tbody tr')]
  const alpha = (row) => Number(row.children[4].dataset.v ?? NaN)
  const graded = rows.filter((row) => Number.isFinite(alpha(row))).sort((a, b) => alpha(a) - alpha(b))
  const cut = rows.find((row) => row.dataset.grade && row.dataset.grade !== 'not_cut')
  const fallback = (graded[0] ?? cut ?? rows[0])?.dataset.id ?? null
  selection.select(wanted && document.getElementById(`object-${wanted}`) ? wanted : fallback)
}

try {
  start()
} catch (error) {
  // The static page must stay usable: undo what hides parts of it.
  root.classList.remove('js')
  root.dataset.errors = String(error?.stack ?? error)
  throw error
}
