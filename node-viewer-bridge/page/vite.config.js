// The bundle is committed and embedded into the bridge: one page, one script, one style sheet, fixed names,
// nothing that differs from build to build. The bridge answers with ETags, so names need no hashes.
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
      output: {
        codeSplitting: false,
        postBanner: "/* Sextant viewer; contains three.js and uPlot, MIT licence, see licenses.txt */",
        entryFileNames: "page.js",
        assetFileNames: "page[extname]",
      },
    },
  },
  server: {
    host: "127.0.0.1",
    // The bridge hears its own page only.
    proxy: { "/ws": { target: bridge, ws: true, changeOrigin: true, rewriteWsOrigin: true }, "/api": { target: bridge, changeOrigin: true, headers: { origin: bridge } } },
  },
});
