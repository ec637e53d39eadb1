// The bundle is committed and embedded into the bridge: two pages, a script each and what both use, one style sheet,
// fixed names, nothing that differs from build to build. The bridge answers with ETags, so names need no hashes.
import { defineConfig } from "vite";

const bridge = process.env.SEXTANT_BRIDGE ?? "http://127.0.0.1:8600";

export default defineConfig({
  base: "./",
  build: {
    target: "es2022",
    outDir: "dist",
    emptyOutDir: true,
    assetsDir: ".",
    assetsInlineLimit: 0,
    cssCodeSplit: false,
    modulePreload: false,
    sourcemap: false,
    reportCompressedSize: false,
    chunkSizeWarningLimit: 1024,
    rolldownOptions: {
      input: { page: "index.html", camera: "camera.html" },
      output: {
        postBanner: ({ name }) => (name === "page" ? "/* Sextant viewer; contains three.js and uPlot, MIT licence, see licenses.txt */" : ""),
        entryFileNames: "[name].js",
        chunkFileNames: "[name].js",
        assetFileNames: "page[extname]",
        codeSplitting: { groups: [{ name: "shared", test: /src\/(theme|storage|session|panels\/dom)\.ts$/ }] },
      },
    },
  },
  worker: {
    format: "es",
    rolldownOptions: { output: { entryFileNames: "[name].js", assetFileNames: "[name][extname]" } },
  },
  server: {
    host: "127.0.0.1",
    // The bridge hears its own page only.
    proxy: { "/ws": { target: bridge, ws: true, changeOrigin: true, rewriteWsOrigin: true }, "/api": { target: bridge, changeOrigin: true, headers: { origin: bridge } } },
  },
});
