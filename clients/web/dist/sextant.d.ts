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
export declare class Detector {
    #private;
    private constructor();
    /**
     * Loads the module, from beside this file unless `source` says otherwise. Fails for wrong options, and in browsers
     * without SIMD.
     */
    static load(options?: Options, source?: URL | string | BufferSource | WebAssembly.Module): Promise<Detector>;
    /** Changes the options. */
    configure({ families, maxHamming, minEdgePx, inverted, tracking }: Options): void;
    /** The tags in an image, by family, id and place. */
    detect(picture: Picture): Tag[];
    /** Room for the pixels of [`detectPixels`]; valid until the next call. */
    pixels(length: number): Uint8Array<ArrayBuffer>;
    /**
     * The tags in an image that was written into [`pixels`]: grey (one channel) or red, green, blue and one more, which
     * are lost.
     */
    detectPixels(width: number, height: number, stride: number, channels: 1 | 4): Tag[];
    /** Light and sharpness of the last image. */
    light(): Light;
    /**
     * Poses of a tag of the last image by its place in the list, the better first: two where its perspective leaves a
     * doubt. `sizeM` is the edge of its black square.
     */
    poses(tag: number, lens: Lens, sizeM: number): Pose[];
    /** The last image's tags as a message of Sextant's network. */
    observations(camera: string, sequence: number, times: Times): Uint8Array<ArrayBuffer>;
    /** A camera's status as a message of Sextant's network; `host` is the device's name. */
    status(camera: string, host: string, figures: Figures): Uint8Array<ArrayBuffer>;
    /** A JPEG file as a message of Sextant's network; `size` is that of the image that it shows. */
    preview(camera: string, sequence: number, captureNs: bigint, [width, height]: [number, number], jpeg: Uint8Array): Uint8Array<ArrayBuffer>;
}
