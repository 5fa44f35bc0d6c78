// A rock as three.js objects: surface by evidence, contact, centre of mass, ground grid, north arrow.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  Group,
  Line,
  LineBasicMaterial,
  LineDashedMaterial,
  LineLoop,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  SphereGeometry,
  Vector3,
  WireframeGeometry,
} from 'three'
import { bytesOf, floatsOf, indicesOf } from './data.js'
import { niceFloor } from './format.js'

const SEEN = new Color('#b5a78f')
const UNSEEN = new Color('#7f9fc4')
const CONTACT = '#d55e00'
const TOPPLE = '#8a1c3a'

const view = ([east, north, up]) => new Vector3(east, up, -north)

// Facets do not share vertices, so that each can have its own colour and a flat, honest shade.
function facets(rock) {
  const p = floatsOf(rock.p)
  const t = indicesOf(rock.t)
  const seen = rock.s ? bytesOf(rock.s) : null
  const photo = rock.c ? bytesOf(rock.c) : null
  const positions = new Float32Array(t.length * 3)
  const evidence = new Float32Array(t.length * 3)
  const colours = photo ? new Float32Array(t.length * 3) : null
  const mixed = new Color()
  for (let i = 0; i < t.length; i++) {
    const v = t[i]
    positions[3 * i] = p[3 * v]
    positions[3 * i + 1] = p[3 * v + 2]
    positions[3 * i + 2] = -p[3 * v + 1]
    const tone = seen && !seen[Math.floor(i / 3)] ? UNSEEN : SEEN
    tone.toArray(evidence, 3 * i)
    if (colours) mixed.setRGB(photo[3 * v] / 255, photo[3 * v + 1] / 255, photo[3 * v + 2] / 255, 'srgb').toArray(colours, 3 * i)
  }
  const geometry = new BufferGeometry()
  geometry.setAttribute('position', new BufferAttribute(positions, 3))
  geometry.setAttribute('color', new BufferAttribute(evidence, 3))
  geometry.computeVertexNormals()
  geometry.computeBoundingSphere()
  return { geometry, evidence, colours }
}

function ground(radius, step) {
  const n = Math.ceil((radius * 2.1) / step)
  const at = []
  for (let i = -n; i <= n; i++) at.push(-n * step, 0, i * step, n * step, 0, i * step, i * step, 0, -n * step, i * step, 0, n * step)
  const lines = new LineSegments(
    new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(at), 3)),
    new LineBasicMaterial({ color: '#9aa3a8', transparent: true, opacity: 0.42 }),
  )
  return lines
}

function arrow(from, direction, length, colour) {
  const side = new Vector3(direction.z, 0, -direction.x).multiplyScalar(length * 0.09)
  const tip = from.clone().addScaledVector(direction, length)
  const neck = from.clone().addScaledVector(direction, length * 0.78)
  const points = [from, tip, neck.clone().add(side), tip, neck.clone().sub(side)]
  return new Line(new BufferGeometry().setFromPoints(points), new LineBasicMaterial({ color: colour }))
}

export function buildRock(rock) {
  const group = new Group()
  const { geometry, evidence, colours } = facets(rock)
  const sphere = geometry.boundingSphere
  const radius = Math.max(sphere.radius, 0.02)
  const material = new MeshStandardMaterial({ vertexColors: true, roughness: 0.95, side: DoubleSide, flatShading: true,
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 })
  group.add(new Mesh(geometry, material))
  const wire = new LineSegments(
    new WireframeGeometry(geometry),
    new LineBasicMaterial({ color: '#2a3238', transparent: true, opacity: 0.35 }),
  )
  group.add(wire)

  const gridStep = niceFloor(radius * 0.6)
  group.add(ground(radius, gridStep))
  const north = new Vector3(0, 0, -1)
  group.add(arrow(new Vector3(-radius * 1.5, 0.001, radius * 0.5), north, radius * 0.7, '#3d474d'))

  if (rock.contact) {
    const points = rock.contact.map(view)
    const style = rock.assumed
      ? new LineDashedMaterial({ color: CONTACT, dashSize: radius * 0.07, gapSize: radius * 0.045, depthTest: false, transparent: true })
      : new LineBasicMaterial({ color: CONTACT, depthTest: false, transparent: true })
    const loop = new LineLoop(new BufferGeometry().setFromPoints(points), style)
    loop.computeLineDistances()
    loop.renderOrder = 2
    group.add(loop)
  }
  if (rock.com) {
    const com = view(rock.com)
    const dot = new Mesh(
      new SphereGeometry(radius * 0.035, 20, 14),
      new MeshBasicMaterial({ color: '#14181b', depthTest: false, transparent: true }),
    )
    dot.position.copy(com)
    dot.renderOrder = 3
    const floor = rock.contact ? Math.min(...rock.contact.map((q) => q[2])) : 0
    const plumb = new Line(
      new BufferGeometry().setFromPoints([com, new Vector3(com.x, floor, com.z)]),
      new LineBasicMaterial({ color: '#14181b', depthTest: false, transparent: true, opacity: 0.7 }),
    )
    plumb.renderOrder = 3
    group.add(dot, plumb)
    if (rock.topple_toward_deg !== undefined) {
      const a = (rock.topple_toward_deg * Math.PI) / 180
      const shaft = arrow(com, new Vector3(Math.sin(a), 0, -Math.cos(a)), radius * 1.25, TOPPLE)
      shaft.material.depthTest = false
      shaft.material.transparent = true
      shaft.renderOrder = 4
      group.add(shaft)
    }
  }

  return {
    group,
    gridStep,
    radius,
    centre: sphere.center.clone(),
    setMode(mode) {
      wire.visible = mode === 'mesh'
      geometry.setAttribute('color', new BufferAttribute(mode === 'colour' && colours ? colours : evidence, 3))
    },
    dispose() {
      group.traverse((node) => {
        node.geometry?.dispose()
        node.material?.dispose()
      })
    },
  }
}
