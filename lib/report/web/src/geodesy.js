// Local east-north-up to latitude and longitude on WGS 84, exact to well below a millimetre.
const A = 6378137
const F = 1 / 298.257223563
const E2 = F * (2 - F)

export function createFrame([latitude, longitude, height]) {
  const phi = (latitude * Math.PI) / 180
  const lambda = (longitude * Math.PI) / 180
  const [sp, cp, sl, cl] = [Math.sin(phi), Math.cos(phi), Math.sin(lambda), Math.cos(lambda)]
  const n = A / Math.sqrt(1 - E2 * sp * sp)
  const x0 = (n + height) * cp * cl
  const y0 = (n + height) * cp * sl
  const z0 = (n * (1 - E2) + height) * sp
  return (east, north, up = 0) => {
    const x = x0 - sl * east - sp * cl * north + cp * cl * up
    const y = y0 + cl * east - sp * sl * north + cp * sl * up
    const z = z0 + cp * north + sp * up
    const p = Math.hypot(x, y)
    let lat = Math.atan2(z, p * (1 - E2))
    for (let i = 0; i < 5; i++) {
      const s = Math.sin(lat)
      lat = Math.atan2(z + (E2 * A * s) / Math.sqrt(1 - E2 * s * s), p)
    }
    return [(lat * 180) / Math.PI, (Math.atan2(y, x) * 180) / Math.PI]
  }
}
