// Bundle src/ and KaTeX into the folder given as argument. Run by build_hook.py, or by hand: npm run build -- DIR
import { cp, mkdir, readFile, readdir, writeFile } from "node:fs/promises";
import { extname, join } from "node:path";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";
import { build } from "esbuild";
import { minify } from "terser";

const out = process.argv[2] ?? "../static";
const katex = "node_modules/katex/dist";

await build({
  entryPoints: [
    "src/js/theme.js",
    "src/js/app.js",
    "src/js/exercise.js",
    "src/js/answers.js",
    "src/js/preview.js",
    "src/js/board.js",
    "src/js/lesson.js",
    "src/js/reading.js",
    "src/js/rubric.js",
    "src/js/studio.js",
    "src/js/replays/index.js",
    "src/js/manipulations/index.js",
    "src/js/steps/index.js",
    "src/css/app.css",
    "src/css/preview.css",
    "src/css/steps.css",
  ],
  chunkNames: "js/[name]-[hash]",
  outdir: out,
  outbase: "src",
  bundle: true,
  splitting: true,
  format: "esm",
  minify: true,
  legalComments: "eof",
  target: ["es2022", "safari16"],
  logLevel: "warning",
});

// Browsers refuse modules from a folder: the pages of an archive have one plain script.
await build({
  entryPoints: ["src/js/offline.js"],
  outdir: out,
  outbase: "src",
  bundle: true,
  format: "iife",
  minify: true,
  legalComments: "eof",
  target: ["es2022", "safari16"],
  logLevel: "warning",
});

// What esbuild leaves, Terser makes three hundredths smaller as it is sent.
for (const script of await readdir(join(out, "js"), { recursive: true })) {
  if (extname(script) !== ".js") continue;
  const path = join(out, "js", script);
  const { code } = await minify(await readFile(path, "utf8"), {
    module: script !== "offline.js",
    ecma: 2020,
    compress: { passes: 2 },
  });
  await writeFile(path, code);
}

await mkdir(join(out, "katex/fonts"), { recursive: true });
await cp(join(katex, "katex.min.js"), join(out, "katex/katex.min.js"));
const css = await readFile(join(katex, "katex.min.css"), "utf8");
const oldFonts = /,url\(fonts\/[^)]+\.(?:woff|ttf)\) format\("(?:woff|truetype)"\)/g;
await writeFile(join(out, "katex/katex.min.css"), css.replace(oldFonts, ""));
for (const font of await readdir(join(katex, "fonts"))) {
  if (font.endsWith(".woff2")) await cp(join(katex, "fonts", font), join(out, "katex/fonts", font));
}
await cp("src/img", join(out, "img"), { recursive: true });

// Compressed once, as small as can be, beside each text: the server has but to choose.
const packed = new Set([".js", ".css", ".svg"]);
const least = 1024;
for (const entry of await readdir(out, { recursive: true, withFileTypes: true })) {
  if (!entry.isFile() || !packed.has(extname(entry.name))) continue;
  const path = join(entry.parentPath, entry.name);
  const content = await readFile(path);
  if (content.length < least) continue;
  const options = { [constants.BROTLI_PARAM_QUALITY]: constants.BROTLI_MAX_QUALITY, [constants.BROTLI_PARAM_SIZE_HINT]: content.length };
  await writeFile(`${path}.br`, brotliCompressSync(content, { params: options }));
  await writeFile(`${path}.gz`, gzipSync(content, { level: constants.Z_BEST_COMPRESSION }));
}
