// Labels that would lie over one another: how far each is lifted so that all can be read.

/** Where a label would lie: its middle at the bottom, and its extent, in pixels of the page. */
export interface LabelBox {
  x: number;
  bottom: number;
  width: number;
  height: number;
}

/**
 * Pixels by which each label is lifted. Whoever comes first stays where it is; so that labels keep their order while things move, the caller gives them
 * in the same order each time.
 */
export function lifts(boxes: readonly LabelBox[]): number[] {
  const placed: LabelBox[] = [];
  return boxes.map((box) => {
    let bottom = box.bottom;
    // From the lowest up, each neighbour is passed once.
    const beside = placed
      .filter((other) => Math.abs(other.x - box.x) < (other.width + box.width) / 2)
      .sort((a, b) => b.bottom - a.bottom);
    for (const other of beside) {
      const over = bottom > other.bottom - other.height && bottom - box.height < other.bottom;
      if (over) bottom = other.bottom - other.height;
    }
    placed.push({ ...box, bottom });
    return box.bottom - bottom;
  });
}
