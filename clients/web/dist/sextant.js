// AprilTags and ArUco markers in pictures, by the detector of Sextant's camera nodes, compiled to WebAssembly with
// 128-bit vectors.
//
//     const detector = await Detector.load({ families: ["tag36h11"] });
//     for (const tag of detector.detect(context.getImageData(0, 0, width, height))) console.log(tag.id, tag.corners);
//
// Runs in pages, in workers and in Node.js. One detector works on one image at a time; each has an instance of the
// module.
const FIGURES_OF_TAG = 24;
const FIGURES_OF_POSE = 8;
/** Where the module is, beside this file. */
const beside = () => new URL("./sextant.wasm", import.meta.url);
/** The bytes of a file; from the disk under Node.js, whose `fetch` reads none. */
async function bytesOf(source) {
    if (String(source).startsWith("file:")) {
        const files = (await import(/* @vite-ignore */ "node:fs"));
        return files.readFileSync(new URL(source));
    }
    const response = await fetch(source);
    if (!response.ok)
        throw new Error(`${source}: ${response.status} ${response.statusText}`);
    return response.arrayBuffer();
}
export class Detector {
    #module;
    #families = [];
    constructor(module) {
        this.#module = module;
        for (let number = 0;; number++) {
            const length = module.sextant_family(number);
            if (length < 0)
                break;
            this.#families.push(new TextDecoder().decode(this.#bytes()));
        }
    }
    /**
     * Loads the module, from beside this file unless `source` says otherwise. Fails for wrong options, and in browsers
     * without SIMD.
     */
    static async load(options = {}, source = beside()) {
        const code = source instanceof URL || typeof source === "string" ? await bytesOf(source) : source;
        const module = code instanceof WebAssembly.Module ? code : await WebAssembly.compile(code);
        const instance = await WebAssembly.instantiate(module);
        const detector = new Detector(instance.exports);
        detector.configure(options);
        return detector;
    }
    /** Changes the options. */
    configure({ families = ["tag36h11"], maxHamming = 2, minEdgePx = 8, inverted = false, tracking = false }) {
        this.#text(families.join(","));
        this.#numbers([maxHamming, minEdgePx, Number(inverted), Number(tracking)]);
        this.#checked(this.#module.sextant_configure());
    }
    /** The tags in an image, by family, id and place. */
    detect(picture) {
        const { data, width, height, stride = width } = picture;
        const channels = "colorSpace" in picture ? 4 : 1;
        this.pixels(data.byteLength).set(data);
        return this.detectPixels(width, height, stride, channels);
    }
    /** Room for the pixels of [`detectPixels`]; valid until the next call. */
    pixels(length) {
        const begin = this.#module.sextant_pixels(length);
        if (begin === 0)
            throw new RangeError(`an image of ${length} bytes is too large`);
        return new Uint8Array(this.#module.memory.buffer, begin, length);
    }
    /**
     * The tags in an image that was written into [`pixels`]: grey (one channel) or red, green, blue and one more, which
     * are lost.
     */
    detectPixels(width, height, stride, channels) {
        const count = this.#checked(this.#module.sextant_detect(width, height, stride, channels));
        const figures = this.#figures(count * FIGURES_OF_TAG);
        return Array.from({ length: count }, (_, tag) => this.#tag(figures.subarray(tag * FIGURES_OF_TAG)));
    }
    /** Light and sharpness of the last image. */
    light() {
        const [brightness = 0, sharpness = 0] = this.#figures(this.#checked(this.#module.sextant_light()));
        return { brightness, sharpness };
    }
    /**
     * Poses of a tag of the last image by its place in the list, the better first: two where its perspective leaves a
     * doubt. `sizeM` is the edge of its black square.
     */
    poses(tag, lens, sizeM) {
        this.#numbers([sizeM, lens.fx, lens.fy, lens.cx, lens.cy, ...(lens.distortion ?? [0, 0, 0, 0, 0])]);
        const count = this.#checked(this.#module.sextant_pose(tag));
        const figures = this.#figures(count * FIGURES_OF_POSE);
        return Array.from({ length: count }, (_, pose) => {
            const [x, y, z, qx, qy, qz, qw, rmsPx] = figures.subarray(pose * FIGURES_OF_POSE);
            return { position: [x, y, z], orientation: [qx, qy, qz, qw], rmsPx: rmsPx };
        });
    }
    /** The last image's tags as a message of Sextant's network. */
    observations(camera, sequence, times) {
        this.#text(camera);
        const { captureNs, receivedNs, detectedNs, isArrival } = times;
        this.#checked(this.#module.sextant_observations(BigInt(sequence), captureNs, receivedNs, detectedNs, Number(isArrival)));
        return this.#bytes();
    }
    /** A camera's status as a message of Sextant's network; `host` is the device's name. */
    status(camera, host, figures) {
        this.#text(`${camera}\n${host}`);
        const { captured, detected, published, rateHz, detectMs, uptimeS } = figures;
        this.#numbers([captured, detected, published, rateHz, ...detectMs, uptimeS]);
        this.#checked(this.#module.sextant_status());
        return this.#bytes();
    }
    /** A JPEG file as a message of Sextant's network; `size` is that of the image that it shows. */
    preview(camera, sequence, captureNs, [width, height], jpeg) {
        this.#text(camera);
        this.pixels(jpeg.byteLength).set(jpeg);
        this.#checked(this.#module.sextant_preview(BigInt(sequence), captureNs, width, height));
        return this.#bytes();
    }
    #tag(figures) {
        const corner = (i) => [figures[4 + 2 * i], figures[5 + 2 * i]];
        const covariance = (i) => [figures[12 + 3 * i], figures[13 + 3 * i], figures[14 + 3 * i]];
        return {
            family: this.#families[figures[0]] ?? "",
            id: figures[1],
            hamming: figures[2],
            margin: figures[3],
            corners: [corner(0), corner(1), corner(2), corner(3)],
            cornerCovariance: [0, 1, 2, 3].map(covariance),
        };
    }
    #checked(count) {
        if (count < 0)
            throw new Error(new TextDecoder().decode(this.#bytes()));
        return count;
    }
    #text(text) {
        const bytes = new TextEncoder().encode(text);
        const begin = this.#module.sextant_text(bytes.length);
        if (begin === 0)
            throw new RangeError(`a text of ${bytes.length} bytes is too long`);
        new Uint8Array(this.#module.memory.buffer, begin, bytes.length).set(bytes);
    }
    #numbers(numbers) {
        new Float64Array(this.#module.memory.buffer, this.#module.sextant_numbers(), numbers.length).set(numbers);
    }
    #figures(length) {
        return new Float64Array(this.#module.memory.buffer, this.#module.sextant_figures(), length);
    }
    /** A copy. */
    #bytes() {
        const { memory, sextant_bytes, sextant_bytes_length } = this.#module;
        return new Uint8Array(memory.buffer, sextant_bytes(), sextant_bytes_length()).slice();
    }
}
