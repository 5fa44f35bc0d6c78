// The 3-D view of the selected rock. One renderer serves all rocks; it draws on demand only.
import { Vector3 } from 'three'
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js'
import { buildRock } from './rock_model.js'
import { createStage } from './rock_stage.js'

const root = document.documentElement

export function createRockView(data) {
  let stage = null
  let failed = false
  let controls = null
  let holder = null
  let model = null
  let mode = 'evidence'

  function begin() {
    if (stage || failed) return
    try {
      stage = createStage()
      controls = new OrbitControls(stage.camera, stage.canvas)
      controls.enablePan = false
      controls.addEventListener('change', draw)
    } catch (error) {
      failed = true
      root.dataset.webgl = 'unavailable'
    }
  }

  function draw() {
    if (!model || !holder?.isConnected) return
    const width = holder.clientWidth
    const height = holder.clientHeight
    if (width < 2 || height < 2) return
    stage.render(model, width, height)
    root.dataset.webgl = 'drawn'
    root.dataset.webglTriangles = String(stage.triangles())
  }

  function buttons(rock) {
    const bar = document.createElement('div')
    bar.className = 'scene-tools'
    const modes = [['evidence', 'Evidence']]
    if (rock.c) modes.push(['colour', 'Colours'])
    modes.push(['mesh', 'Mesh'])
    for (const [name, label] of modes) {
      const button = document.createElement('button')
      button.type = 'button'
      button.textContent = label
      button.setAttribute('aria-pressed', String(name === mode))
      button.addEventListener('click', () => {
        mode = name
        model.setMode(mode)
        for (const other of bar.children) other.setAttribute('aria-pressed', String(other === button))
        draw()
      })
      bar.append(button)
    }
    return bar
  }

  function key(rock) {
    const list = document.createElement('ul')
    list.className = 'scene-key'
    const entries = [['seen', rock.s ? 'seen' : 'surface']]
    if (rock.s) entries.push(['unseen', 'filled in'])
    if (rock.contact) entries.push(['contact', rock.assumed ? 'contact, assumed' : 'contact'])
    if (rock.com) entries.push(['mass', 'centre of mass'])
    if (rock.topple_toward_deg !== undefined) entries.push(['topple', 'toppling toward'])
    for (const [name, label] of entries) {
      const item = document.createElement('li')
      const mark = document.createElement('i')
      mark.className = `mark-${name}`
      item.append(mark, label)
      list.append(item)
    }
    return list
  }

  function look() {
    const size = model.radius
    controls.target.copy(model.centre)
    stage.camera.position.copy(model.centre).add(new Vector3(1.15, 0.95, 1.75).multiplyScalar(size * 1.72))
    stage.camera.near = size / 50
    stage.camera.far = size * 60
    controls.minDistance = size * 0.7
    controls.maxDistance = size * 12
    controls.update()
  }

  new ResizeObserver(() => draw()).observe(document.getElementById('panel'))

  return {
    show(element) {
      holder = element
      model?.dispose()
      model = null
      if (!element) return
      begin()
      const rock = data.rocks.get(element.dataset.rock)
      const note = element.querySelector('.scene-note')
      if (failed || !rock?.p) {
        if (note) note.textContent = failed ? 'This browser offers no WebGL, so the 3-D view cannot be drawn.' : note.textContent
        return
      }
      if (mode === 'colour' && !rock.c) mode = 'evidence'
      model = buildRock(rock)
      model.setMode(mode)
      const caption = document.createElement('p')
      caption.className = 'scene-caption'
      caption.textContent =
        `Grid ${model.gridStep >= 1 ? model.gridStep + '\u202fm' : Math.round(model.gridStep * 100) + '\u202fcm'}; arrow to north` +
        (rock.triangles < rock.of ? `; thinned from ${rock.of} triangles` : '')
      element.replaceChildren(stage.canvas, buttons(rock), key(rock), caption)
      look()
      draw()
    },
  }
}
