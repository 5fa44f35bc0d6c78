// Numbers for people.
export const minus = (text) => text.replace('-', '\u2212')
export const fixed = (value, decimals) => minus(value.toFixed(decimals))

// The next of 1, 2, 5 times a power of ten at or below value.
export function niceFloor(value) {
  const power = 10 ** Math.floor(Math.log10(value))
  const lead = value / power
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power
}

export const metres = (value) =>
  value >= 1000 ? `${value / 1000}\u202fkm` : value >= 1 ? `${value}\u202fm` : `${Math.round(value * 100)}\u202fcm`

export const degreesNorth = (v) => `${Math.abs(v).toFixed(6)}° ${v < 0 ? 'S' : 'N'}`
export const degreesEast = (v) => `${Math.abs(v).toFixed(6)}° ${v < 0 ? 'W' : 'E'}`
