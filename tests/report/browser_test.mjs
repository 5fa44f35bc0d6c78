// The report in headless Chromium: node browser_test.mjs REPORT_SAMPLE_PROGRAM [SCREENSHOT_FOLDER]
import assert from 'node:assert/strict'
import { execFileSync } from 'node:child_process'
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { openBrowser } from './browser.mjs'

const [program, shots] = process.argv.slice(2)
const folder = mkdtempSync(join(tmpdir(), 'cairn-report-'))
const made = new Map()
function sample(kind) {
  if (!made.has(kind)) {
    const file = join(folder, `${kind}.html`)
    execFileSync(program, [kind, file])
    made.set(kind, `file://${file}`)
  }
  return made.get(kind)
}
const keep = async (page, name, full = false) => {
  if (shots) writeFileSync(join(shots, `${name}.png`), await page.screenshot(full))
}

const browser = await openBrowser()
const ready = async (kind, options = {}) => {
  const page = await browser.page(sample(kind) + (options.hash ?? ''), options)
  await page.until('document.documentElement.dataset.ready === "true"')
  return page
}
const noProblems = async (page) => {
  assert.deepEqual(page.problems, [])
  assert.equal(await page.evaluate('document.documentElement.dataset.errors ?? ""'), '')
}
const onlyOwnFile = (page) => {
  for (const url of page.requests) assert.match(url, /^(file|data|blob):/)
}
const centre = (page, selector) =>
  page.evaluate(`(() => { const b = document.querySelector(${JSON.stringify(selector)}).getBoundingClientRect();
    return [b.x + b.width / 2, b.y + b.height / 2] })()`)
const selected = (page) => page.evaluate('document.querySelector(".object.selected")?.dataset.id')

const tests = {
  async 'opens without an error and asks for nothing but itself'() {
    const page = await ready('full')
    await noProblems(page)
    onlyOwnFile(page)
    assert.equal(page.requests.filter((url) => url.startsWith('file:')).length, 1)
    await keep(page, 'desktop')
  },

  async 'shows every object once in table, map and panel'() {
    const page = await ready('full')
    assert.equal(await page.evaluate('document.querySelectorAll("table.objects tbody tr").length'), 42)
    assert.equal(await page.evaluate('document.querySelectorAll(".target").length'), 42)
    assert.equal(await page.evaluate('document.querySelectorAll(".object").length'), 42)
    assert.equal(await page.evaluate('[...document.querySelectorAll(".object")].filter((o) => o.offsetHeight > 0).length'), 1)
  },

  async 'draws the selected rock with WebGL'() {
    const page = await ready('full', { hash: '#object-2' })
    assert.equal(await page.evaluate('document.documentElement.dataset.webgl'), 'drawn')
    assert.equal(await selected(page), '2')
    const colours = await page.evaluate(`(() => {
      const canvas = document.querySelector('.object.selected canvas')
      const copy = document.createElement('canvas')
      copy.width = canvas.width; copy.height = canvas.height
      const context = copy.getContext('2d')
      context.drawImage(canvas, 0, 0)
      const bytes = context.getImageData(0, 0, copy.width, copy.height).data
      const seen = new Set(); let solid = 0
      for (let i = 0; i < bytes.length; i += 4) if (bytes[i + 3] > 200) { solid++; seen.add(bytes[i] << 16 | bytes[i + 1] << 8 | bytes[i + 2]) }
      return { share: solid / (bytes.length / 4), kinds: seen.size }
    })()`)
    assert.ok(colours.share > 0.08, `the rock covers ${colours.share} of its view`)
    assert.ok(colours.kinds > 50, `${colours.kinds} colours: lit, not flat`)
    await keep(page, 'rock')
  },

  async 'a rock that is not measurable has no tipping figure anywhere'() {
    const page = await ready('full', { hash: '#object-1' })
    const row = '[...document.querySelectorAll("table.objects tbody tr")].find((r) => r.dataset.id === "1")'
    assert.equal(await page.evaluate(`${row}.dataset.grade`), 'not_measurable')
    assert.deepEqual(await page.evaluate(`[4, 5, 6].map((i) => ${row}.children[i].textContent)`), ['', '', ''])
    const text = await page.evaluate('document.querySelector(".object.selected .tipping").innerText')
    assert.match(text, /No tipping figure is given/)
    assert.doesNotMatch(text, /\d/)
    await keep(page, 'not_measurable')
  },

  async 'a click on the map selects the object in table and panel'() {
    const page = await ready('full')
    const [x, y] = await centre(page, '.target[data-id="8"] path')
    await page.click(x, y)
    assert.equal(await selected(page), '8')
    assert.equal(await page.evaluate('document.querySelector("tr.selected").dataset.id'), '8')
  },

  async 'a click on a row selects the object and brings the map into view'() {
    const page = await ready('full')
    await page.evaluate('document.querySelector("#objects").scrollIntoView()')
    await page.settle()
    const [x, y] = await centre(page, 'table.objects tbody tr[data-id="6"] td:nth-child(3)')
    await page.click(x, y)
    await page.until('(() => { const b = document.querySelector("#explore").getBoundingClientRect(); return b.top > -60 && b.top < 400 })()')
    assert.equal(await selected(page), '6')
    assert.ok(await page.evaluate('document.querySelector(".target.selected").dataset.id === "6"'))
  },

  async 'the wheel zooms about the pointer and a drag pans'() {
    const page = await ready('full')
    const box = () => page.evaluate('document.querySelector(".map-svg").getAttribute("viewBox").split(" ").map(Number)')
    const [x, y] = await centre(page, '.map-svg')
    const before = await box()
    await page.mouse('mouseWheel', x + 100, y, { deltaX: 0, deltaY: -400 })
    await page.settle()
    const zoomed = await box()
    assert.ok(zoomed[2] < before[2] * 0.7)
    const size = await page.evaluate('document.querySelector(".map-frame").clientWidth')
    const fixed = (b) => b[0] + b[2] * (0.5 + 100 / size)
    assert.ok(Math.abs(fixed(zoomed) - fixed(before)) < 0.01 * before[2], 'the point under the pointer stays')
    await page.mouse('mouseMoved', x, y)
    await page.mouse('mousePressed', x, y)
    await page.mouse('mouseMoved', x + 60, y + 30, { buttons: 1 })
    await page.mouse('mouseReleased', x + 60, y + 30)
    await page.settle()
    const panned = await box()
    assert.ok(panned[0] < zoomed[0] && panned[1] < zoomed[1])
    await keep(page, 'zoomed')
  },

  async 'coordinates and raster values are read out under the pointer'() {
    const page = await ready('full')
    const [x, y] = await centre(page, '.map-svg')
    await page.mouse('mouseMoved', x, y)
    await page.settle()
    await page.mouse('mouseMoved', x + 1, y)
    await page.settle()
    const text = await page.evaluate('document.querySelector(".cursor").textContent')
    assert.match(text, /E.*N.*46\.84\d+° N, 91\.99\d+° W.*height 16\d\.\d+.*\d+ views.*cost/s)
  },

  async 'the page agrees with C++ on latitude and longitude'() {
    const page = await ready('full')
    const worst = await page.evaluate(`(() => {
      const rows = [...document.querySelectorAll('table.objects tbody tr')]
      const v = (row, i) => Number(row.children[i].dataset.v)
      return rows.map((r) => [v(r, 15), v(r, 16), v(r, 17), v(r, 18), v(r, 19)])
    })()`)
    const { createFrame } = await import('../../lib/report/web/src/geodesy.js')
    const geodetic = createFrame([46.8426, -91.994, 158.0])
    for (const [e, n, u, latitude, longitude] of worst) {
      const [lat, lon] = geodetic(e, n, u)
      // 1e-9 deg is a tenth of a millimetre.
      assert.ok(Math.abs(lat - latitude) < 1e-9 && Math.abs(lon - longitude) < 1e-9)
    }
  },

  async 'grounds and layers switch'() {
    const page = await ready('full')
    const shown = (layer) => page.evaluate(`getComputedStyle(document.querySelector('[data-layer="${layer}"]')).display !== 'none'`)
    assert.equal(await shown('views'), false)
    await page.evaluate('document.querySelector("#u-views").click()')
    assert.equal(await shown('views'), true)
    assert.equal(await shown('tint'), false)
    await keep(page, 'views')
    await page.evaluate('document.querySelector("#u-costmap").click()')
    await page.evaluate('document.querySelector("#o-footprints").click()')
    await page.evaluate('document.querySelector("#o-gaps").click()')
    assert.equal(await shown('footprints'), true)
    assert.equal(await shown('gaps'), true)
    await page.evaluate('document.querySelector("#o-targets").click()')
    assert.equal(await shown('targets'), false)
    await keep(page, 'costmap')
  },

  async 'columns sort both ways with blanks last'() {
    const page = await ready('full')
    const column = (i) => page.evaluate(`[...document.querySelectorAll('table.objects tbody tr')].map((r) => r.children[${i}].dataset.v ?? null)`)
    const press = (key) => page.evaluate(`document.querySelector('th[data-key="${key}"] button').click()`)
    await press('alpha_deg')
    const up = await column(4)
    const numbers = up.filter((v) => v !== null).map(Number)
    assert.ok(numbers.length > 3)
    assert.deepEqual(numbers, [...numbers].sort((a, b) => a - b))
    assert.ok(up.slice(numbers.length).every((v) => v === null))
    await press('alpha_deg')
    const down = await column(4)
    assert.deepEqual(down.slice(0, numbers.length).map(Number), [...numbers].reverse())
    assert.equal(down.at(-1), null)
  },

  async 'filters leave the rows that fit'() {
    const page = await ready('full')
    const visible = () => page.evaluate('[...document.querySelectorAll("table.objects tbody tr")].filter((r) => !r.hidden).map((r) => r.dataset.class)')
    await page.evaluate(`(() => { const s = document.querySelector('.table-tools select'); s.value = 'tree'; s.dispatchEvent(new Event('change')) })()`)
    const rows = await visible()
    assert.equal(rows.length, 9)
    assert.ok(rows.every((c) => c === 'tree'))
    assert.match(await page.evaluate('document.querySelector(".table-tools output").textContent'), /9 of 42/)
  },

  async 'cells that spreadsheets would run are quoted in the CSV'() {
    const { csvCell } = await import('../../lib/report/web/src/table.js')
    assert.equal(csvCell('=HYPERLINK("x")'), '"\'=HYPERLINK(""x"")"')
    assert.equal(csvCell('@cmd'), "'@cmd")
    assert.equal(csvCell('-1.5e-3'), '-1.5e-3')
    assert.equal(csvCell('-cmd'), "'-cmd")
    assert.equal(csvCell('a,b'), '"a,b"')
  },

  async 'a gap in the list is shown on the map'() {
    const page = await ready('full')
    await page.evaluate('document.querySelector("tr[data-gap=\\"5\\"]").click()')
    await page.settle()
    assert.equal(await page.evaluate('document.querySelector(".gap.selected").dataset.gap'), '5')
    assert.ok(await page.evaluate('document.querySelector("#o-gaps").checked'))
  },

  async 'hostile names stay text'() {
    const page = await ready('hostile')
    await page.settle()
    assert.equal(await page.evaluate('document.documentElement.dataset.broken ?? ""'), '')
    await noProblems(page)
    assert.equal(await page.evaluate('document.querySelectorAll("img").length'), 1)
    assert.equal(await page.evaluate('document.querySelectorAll("script").length'), 3)
    assert.ok(await page.evaluate('document.querySelector("h1").textContent.includes("<script>")'))
    await page.evaluate('document.querySelector("th[data-key=class] button").click()')
    assert.equal(await page.evaluate('document.documentElement.dataset.broken ?? ""'), '')
    onlyOwnFile(page)
  },

  async 'an injected script would not run'() {
    const page = await ready('tiny')
    await page.evaluate(`(() => { const s = document.createElement('script')
      s.textContent = 'document.documentElement.dataset.broken = "yes"'; document.body.append(s) })()`)
    assert.equal(await page.evaluate('document.documentElement.dataset.broken ?? ""'), '', 'the content security policy stops it')
  },

  async 'a report with one object and nothing else works'() {
    const page = await ready('tiny')
    await noProblems(page)
    assert.equal(await selected(page), '1')
  },

  async 'without JavaScript everything can be read'() {
    const page = await browser.page(sample('full'), { script: false })
    await page.settle()
    const { root } = await page.call('DOM.getDocument', { depth: 0 })
    const { nodeIds } = await page.call('DOM.querySelectorAll', { nodeId: root.nodeId, selector: '.object' })
    assert.equal(nodeIds.length, 42)
    for (const nodeId of nodeIds) {
      const { model } = await page.call('DOM.getBoxModel', { nodeId })
      assert.ok(model.height > 60, 'each object is laid out')
    }
    await keep(page, 'no_script')
  },

  async 'a narrow screen does not scroll sideways'() {
    const page = await ready('full', { width: 420, height: 900, touch: true })
    await noProblems(page)
    assert.ok(await page.evaluate('document.documentElement.scrollWidth <= 420'))
    await keep(page, 'narrow')
    await page.evaluate('document.querySelector("#explore").scrollIntoView()')
    await keep(page, 'narrow_map')
  },

  async 'prints all objects'() {
    const page = await ready('full')
    await page.call('Emulation.setEmulatedMedia', { media: 'print' })
    assert.equal(await page.evaluate('[...document.querySelectorAll(".object")].filter((o) => o.offsetHeight > 0).length'), 42)
    assert.equal(await page.evaluate('getComputedStyle(document.querySelector(".contents")).display'), 'none')
    const { data } = await page.call('Page.printToPDF', { printBackground: true })
    const pdf = Buffer.from(data, 'base64')
    assert.equal(pdf.subarray(0, 5).toString(), '%PDF-')
    if (shots) writeFileSync(join(shots, 'report.pdf'), pdf)
  },
}

let failed = 0
for (const [name, test] of Object.entries(tests)) {
  try {
    await test()
    console.log(`ok      ${name}`)
  } catch (error) {
    failed++
    console.log(`FAILED  ${name}\n${error.stack}`)
  }
  await browser.closePages()
}
await browser.close()
rmSync(folder, { recursive: true, force: true })
console.log(failed ? `${failed} of ${Object.keys(tests).length} tests failed` : `${Object.keys(tests).length} tests passed`)
process.exit(failed ? 1 : 0)
