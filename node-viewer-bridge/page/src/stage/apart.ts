// Labels that would lie over one another: how far each is lifted so that all can be read. Allocates nothing once it has
// grown.

/** Where a label would lie: its middle at the bottom, and its extent, in pixels of the page. */
export interface LabelBox {
  x: number;
  bottom: number;
  width: number;
  height: number;
}

/**
 * The places that are taken. Whoever comes first stays where it is; the caller asks for labels in the same order each
 * time.
 */
export class Places {
  private readonly boxes: LabelBox[] = [];
  private count = 0;

  clear(): void {
    this.count = 0;
  }

  /** The least lift at which the box lies over none that is there. */
  lift(box: LabelBox): number {
    let lift = 0;
    // Each round passes at least one box that is there.
    for (let round = 0; round <= this.count; round++) {
      const other = this.over(box, box.bottom - lift);
      if (!other) break;
      lift = box.bottom - (other.bottom - other.height);
    }
    return lift;
  }

  isFree(box: LabelBox): boolean {
    return this.over(box, box.bottom) === null;
  }

  take({ x, bottom, width, height }: LabelBox): void {
    const place = (this.boxes[this.count] ??= { x: 0, bottom: 0, width: 0, height: 0 });
    place.x = x;
    place.bottom = bottom;
    place.width = width;
    place.height = height;
    this.count++;
  }

  /** One that the box would lie over with its bottom there. */
  private over(box: LabelBox, bottom: number): LabelBox | null {
    for (let k = 0; k < this.count; k++) {
      const other = this.boxes[k] as LabelBox;
      const beside = Math.abs(other.x - box.x) >= (other.width + box.width) / 2;
      if (!beside && bottom > other.bottom - other.height && bottom - box.height < other.bottom) return other;
    }
    return null;
  }
}
