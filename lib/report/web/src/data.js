// What C++ put into the page, decoded.
export function readData() {
  const data = JSON.parse(document.getElementById('cairn-data').textContent)
  data.rocks = new Map(data.rocks.map((rock) => [String(rock.id), rock]))
  return data
}

export function bytesOf(base64) {
  const text = atob(base64)
  const bytes = new Uint8Array(text.length)
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i)
  return bytes
}

export const floatsOf = (base64) => new Float32Array(bytesOf(base64).buffer)
export const indicesOf = (base64) => new Uint32Array(bytesOf(base64).buffer)

// A grid of 16-bit counts, compressed; values in the grid's own unit, NaN where there is no data.
export async function openGrid(grid) {
  const stream = new Blob([bytesOf(grid.data)]).stream().pipeThrough(new DecompressionStream('deflate'))
  const counts = new Uint16Array(await new Response(stream).arrayBuffer())
  return (east, north) => {
    const column = Math.floor((east - grid.west) / grid.cell)
    const row = Math.floor((grid.north - north) / grid.cell)
    if (column < 0 || row < 0 || column >= grid.columns || row >= grid.rows) return NaN
    const count = counts[row * grid.columns + column]
    return count === 65535 ? NaN : grid.offset + grid.step * count
  }
}
