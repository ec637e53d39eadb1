// What a person has chosen on the page: the object that is followed, the camera that is looked through, the pair that
// is measured.

export class Selection {
  object: string | null = null;
  camera: string | null = null;
  /** From the first to the second; both or none. */
  pair: [string, string] | null = null;
  private readonly listeners: (() => void)[] = [];

  changed(listener: () => void): void {
    this.listeners.push(listener);
  }

  /** Follows an object, or none; the camera's eye is left. */
  follow(object: string | null): void {
    this.object = object;
    this.camera = null;
    this.tell();
  }

  lookThrough(camera: string | null): void {
    this.camera = camera;
    this.tell();
  }

  measure(pair: [string, string] | null): void {
    this.pair = pair;
    this.tell();
  }

  /** Leaves the camera's eye, or else the followed object. */
  back(): void {
    if (this.camera !== null) this.lookThrough(null);
    else this.follow(null);
  }

  private tell(): void {
    for (const listener of this.listeners) listener();
  }
}
