// The value under the pointer in a polar diagram.
import { fixed } from './format.js'

const RADIUS = 92
const SVG = 'http://www.w3.org/2000/svg'

export function enhanceCharts(data) {
  for (const article of document.querySelectorAll('.object')) {
    const values = data.polar[article.dataset.id]
    const chart = article.querySelector('.polar')
    if (!values || !chart) continue
    const limit = Number(chart.dataset.limit)
    const layer = chart.querySelector('.readout')
    chart.addEventListener('pointermove', (event) => {
      const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(chart.getScreenCTM().inverse())
      const azimuth = (Math.round((Math.atan2(p.x, -p.y) * 180) / Math.PI) + 360) % 360
      const r = RADIUS * Math.min(1, values[azimuth] / limit)
      const [x, y] = [Math.sin((azimuth * Math.PI) / 180), -Math.cos((azimuth * Math.PI) / 180)]
      const line = document.createElementNS(SVG, 'line')
      const dot = document.createElementNS(SVG, 'circle')
      const text = document.createElementNS(SVG, 'text')
      line.setAttribute('x2', RADIUS * x)
      line.setAttribute('y2', RADIUS * y)
      dot.setAttribute('cx', r * x)
      dot.setAttribute('cy', r * y)
      dot.setAttribute('r', 3)
      text.setAttribute('y', 112)
      text.textContent = `${azimuth}°: ${fixed(values[azimuth], 3)}\u202fg`
      layer.replaceChildren(line, dot, text)
    })
    chart.addEventListener('pointerleave', () => layer.replaceChildren())
  }
}
