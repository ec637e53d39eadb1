// AprilTags and ArUco markers in pictures, by the detector of Sextant's camera nodes, compiled to WebAssembly with
// 128-bit vectors.
//
//     const detector = await Detector.load({ families: ["tag36h11"] });
//     for (const tag of detector.detect(context.getImageData(0, 0, width, height))) console.log(tag.id, tag.corners);
//
// Runs in pages, in workers and in Node.js. One detector works on one image at a time; each has an instance of the
// module.

/** x right, y down; (0, 0) is the centre of the top left pixel. */
export type Point = [x: number, y: number];

/** A tag in an image. */
export interface Tag {
  family: string;
  /** Its number within the family. */
  id: number;
  /** Bits that were corrected. */
  hamming: number;
  /** Mean distance of the bits from their threshold, grey levels. */
  margin: number;
  /** Top left, top right, bottom right, bottom left of the black square of the upright tag. */
  corners: [Point, Point, Point, Point];
  /** Covariance of each corner as xx, xy, yy, square pixels. */
  cornerCovariance: [number, number, number][];
}

/** A tag in the camera's frame: x right, y down, z forward. The tag's own: x right, y up, z out of its face. */
export interface Pose {
  /** Metres. */
  position: [number, number, number];
  /** Quaternion x, y, z, w. */
  orientation: [number, number, number, number];
  /** Root mean square error of the corners, pixels. */
  rmsPx: number;
}

/** Focal lengths and principal point in pixels, and Brown-Conrady's k1, k2, p1, p2, k3. */
export interface Lens {
  fx: number;
  fy: number;
  cx: number;
  cy: number;
  distortion?: [number, number, number, number, number];
}

export interface Options {
  /** Default: tag36h11. All of Sextant's but tagStandard52h13, tagCustom48h12 and tagCircle49h12. */
  families?: string[];
  /** Most bit errors that are corrected, 0 to 2 (default 2). */
  maxHamming?: number;
  /** Least edge of a tag in pixels, 6 to 1000 (default 8). */
  minEdgePx?: number;
  /** Tags printed white for black (default: no). */
  inverted?: boolean;
  /**
   * For consecutive images: searches where tags were and a tenth of the rest, at a fraction of the time (default: no).
   */
  tracking?: boolean;
}

/**
 * An image of grey bytes, `stride` bytes a row (default: `width`), or an `ImageData` of red, green, blue and opacity.
 */
export interface Picture {
  data: Uint8Array | Uint8ClampedArray;
  width: number;
  height: number;
  stride?: number;
}

/** Light and sharpness of an image. */
export interface Light {
  /** Mean grey level, 0 to 255. */
  brightness: number;
  /** 1 for perfect edges, below 0.3 out of focus or smeared, 0 without any edge. */
  sharpness: number;
}

/** When an image was taken and worked on: ns since the Unix epoch, by this device's clock. */
export interface Times {
  captureNs: bigint;
  receivedNs: bigint;
  detectedNs: bigint;
  /** Whether `captureNs` is only when the image arrived. */
  isArrival: boolean;
}

/** Statistics of a camera: counts since it started, images a second, median and 99th percentile of detection in ms. */
export interface Figures {
  captured: number;
  detected: number;
  published: number;
  rateHz: number;
  detectMs: [number, number];
  uptimeS: number;
}

interface Exports {
  memory: WebAssembly.Memory;
  sextant_pixels(length: number): number;
  sextant_text(length: number): number;
  sextant_numbers(): number;
  sextant_figures(): number;
  sextant_bytes(): number;
  sextant_bytes_length(): number;
  sextant_family(number: number): number;
  sextant_configure(): number;
  sextant_detect(width: number, height: number, stride: number, channels: number): number;
  sextant_light(): number;
  sextant_pose(tag: number): number;
  sextant_observations(sequence: bigint, captureNs: bigint, receivedNs: bigint, detectedNs: bigint, isArrival: number): number;
  sextant_status(): number;
  sextant_preview(sequence: bigint, captureNs: bigint, width: number, height: number): number;
}

const FIGURES_OF_TAG = 24;
const FIGURES_OF_POSE = 8;

/** Where the module is, beside this file. */
const beside = () => new URL("./sextant.wasm", import.meta.url);

/** The bytes of a file; from the disk under Node.js, whose `fetch` reads none. */
async function bytesOf(source: URL | string): Promise<BufferSource> {
  if (String(source).startsWith("file:")) {
    const files = (await import(/* @vite-ignore */ "node:fs" as string)) as { readFileSync(file: URL): Uint8Array<ArrayBuffer> };
    return files.readFileSync(new URL(source));
  }
  const response = await fetch(source);
  if (!response.ok) throw new Error(`${source}: ${response.status} ${response.statusText}`);
  return response.arrayBuffer();
}

export class Detector {
  readonly #module: Exports;
  readonly #families: string[] = [];

  private constructor(module: Exports) {
    this.#module = module;
    for (let number = 0; ; number++) {
      const length = module.sextant_family(number);
      if (length < 0) break;
      this.#families.push(new TextDecoder().decode(this.#bytes()));
    }
  }

  /**
   * Loads the module, from beside this file unless `source` says otherwise. Fails for wrong options, and in browsers
   * without SIMD.
   */
  static async load(options: Options = {}, source: URL | string | BufferSource | WebAssembly.Module = beside()): Promise<Detector> {
    const code = source instanceof URL || typeof source === "string" ? await bytesOf(source) : source;
    const module = code instanceof WebAssembly.Module ? code : await WebAssembly.compile(code);
    const instance = await WebAssembly.instantiate(module);
    const detector = new Detector(instance.exports as unknown as Exports);
    detector.configure(options);
    return detector;
  }

  /** Changes the options. */
  configure({ families = ["tag36h11"], maxHamming = 2, minEdgePx = 8, inverted = false, tracking = false }: Options): void {
    this.#text(families.join(","));
    this.#numbers([maxHamming, minEdgePx, Number(inverted), Number(tracking)]);
    this.#checked(this.#module.sextant_configure());
  }

  /** The tags in an image, by family, id and place. */
  detect(picture: Picture): Tag[] {
    const { data, width, height, stride = width } = picture;
    const channels = "colorSpace" in picture ? 4 : 1;
    this.pixels(data.byteLength).set(data);
    return this.detectPixels(width, height, stride, channels);
  }

  /** Room for the pixels of [`detectPixels`]; valid until the next call. */
  pixels(length: number): Uint8Array<ArrayBuffer> {
    const begin = this.#module.sextant_pixels(length);
    if (begin === 0) throw new RangeError(`an image of ${length} bytes is too large`);
    return new Uint8Array(this.#module.memory.buffer as ArrayBuffer, begin, length);
  }

  /**
   * The tags in an image that was written into [`pixels`]: grey (one channel) or red, green, blue and one more, which
   * are lost.
   */
  detectPixels(width: number, height: number, stride: number, channels: 1 | 4): Tag[] {
    const count = this.#checked(this.#module.sextant_detect(width, height, stride, channels));
    const figures = this.#figures(count * FIGURES_OF_TAG);
    return Array.from({ length: count }, (_, tag) => this.#tag(figures.subarray(tag * FIGURES_OF_TAG)));
  }

  /** Light and sharpness of the last image. */
  light(): Light {
    const [brightness = 0, sharpness = 0] = this.#figures(this.#checked(this.#module.sextant_light()));
    return { brightness, sharpness };
  }

  /**
   * Poses of a tag of the last image by its place in the list, the better first: two where its perspective leaves a
   * doubt. `sizeM` is the edge of its black square.
   */
  poses(tag: number, lens: Lens, sizeM: number): Pose[] {
    this.#numbers([sizeM, lens.fx, lens.fy, lens.cx, lens.cy, ...(lens.distortion ?? [0, 0, 0, 0, 0])]);
    const count = this.#checked(this.#module.sextant_pose(tag));
    const figures = this.#figures(count * FIGURES_OF_POSE);
    return Array.from({ length: count }, (_, pose) => {
      const [x, y, z, qx, qy, qz, qw, rmsPx] = figures.subarray(pose * FIGURES_OF_POSE) as unknown as number[] & { length: 8 };
      return { position: [x!, y!, z!], orientation: [qx!, qy!, qz!, qw!], rmsPx: rmsPx! };
    });
  }

  /** The last image's tags as a message of Sextant's network. */
  observations(camera: string, sequence: number, times: Times): Uint8Array<ArrayBuffer> {
    this.#text(camera);
    const { captureNs, receivedNs, detectedNs, isArrival } = times;
    this.#checked(this.#module.sextant_observations(BigInt(sequence), captureNs, receivedNs, detectedNs, Number(isArrival)));
    return this.#bytes();
  }

  /** A camera's status as a message of Sextant's network; `host` is the device's name. */
  status(camera: string, host: string, figures: Figures): Uint8Array<ArrayBuffer> {
    this.#text(`${camera}\n${host}`);
    const { captured, detected, published, rateHz, detectMs, uptimeS } = figures;
    this.#numbers([captured, detected, published, rateHz, ...detectMs, uptimeS]);
    this.#checked(this.#module.sextant_status());
    return this.#bytes();
  }

  /** A JPEG file as a message of Sextant's network; `size` is that of the image that it shows. */
  preview(camera: string, sequence: number, captureNs: bigint, [width, height]: [number, number], jpeg: Uint8Array): Uint8Array<ArrayBuffer> {
    this.#text(camera);
    this.pixels(jpeg.byteLength).set(jpeg);
    this.#checked(this.#module.sextant_preview(BigInt(sequence), captureNs, width, height));
    return this.#bytes();
  }

  #tag(figures: Float64Array): Tag {
    const corner = (i: number): Point => [figures[4 + 2 * i]!, figures[5 + 2 * i]!];
    const covariance = (i: number): [number, number, number] => [figures[12 + 3 * i]!, figures[13 + 3 * i]!, figures[14 + 3 * i]!];
    return {
      family: this.#families[figures[0]!] ?? "",
      id: figures[1]!,
      hamming: figures[2]!,
      margin: figures[3]!,
      corners: [corner(0), corner(1), corner(2), corner(3)],
      cornerCovariance: [0, 1, 2, 3].map(covariance),
    };
  }

  #checked(count: number): number {
    if (count < 0) throw new Error(new TextDecoder().decode(this.#bytes()));
    return count;
  }

  #text(text: string): void {
    const bytes = new TextEncoder().encode(text);
    const begin = this.#module.sextant_text(bytes.length);
    if (begin === 0) throw new RangeError(`a text of ${bytes.length} bytes is too long`);
    new Uint8Array(this.#module.memory.buffer, begin, bytes.length).set(bytes);
  }

  #numbers(numbers: number[]): void {
    new Float64Array(this.#module.memory.buffer, this.#module.sextant_numbers(), numbers.length).set(numbers);
  }

  #figures(length: number): Float64Array {
    return new Float64Array(this.#module.memory.buffer, this.#module.sextant_figures(), length);
  }

  /** A copy. */
  #bytes(): Uint8Array<ArrayBuffer> {
    const { memory, sextant_bytes, sextant_bytes_length } = this.#module;
    return new Uint8Array(memory.buffer as ArrayBuffer, sextant_bytes(), sextant_bytes_length()).slice();
  }
}
