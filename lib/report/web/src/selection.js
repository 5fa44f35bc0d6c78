// Which object is selected, and which one the pointer is on. Map, table and panel listen.
export function createSelection() {
  const onSelect = []
  const onHover = []
  let selected = null
  let hovered = null
  return {
    get selected() {
      return selected
    },
    select(id, how = {}) {
      selected = id
      for (const listener of onSelect) listener(id, how)
    },
    hover(id) {
      if (id === hovered) return
      hovered = id
      for (const listener of onHover) listener(id)
    },
    onSelect: (listener) => onSelect.push(listener),
    onHover: (listener) => onHover.push(listener),
  }
}
