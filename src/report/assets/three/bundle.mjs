// Makes ../three.min.js.gz and ../three-LICENSE from the packages named in package-lock.json:
//   npm ci && npm run build     writes them
//   npm ci && npm run check     fails where they are not what would be written
import { readFile, writeFile } from "node:fs/promises";
import { gunzipSync, gzipSync } from "node:zlib";
import { build } from "esbuild";

const here = (name) => new URL(name, import.meta.url);
const { outputFiles } = await build({
  absWorkingDir: here(".").pathname,
  entryPoints: ["entry.js"],
  bundle: true,
  minify: true,
  format: "iife",
  globalName: "THREE",
  legalComments: "none",
  target: "es2022",
  write: false,
});
const script = outputFiles[0].text;
const licence = await readFile(here("node_modules/three/LICENSE"), "utf8");
const [packed, kept] = [here("../three.min.js.gz"), here("../three-LICENSE")];
if (process.argv.includes("--check")) {
  const same = gunzipSync(await readFile(packed)).toString() === script && (await readFile(kept, "utf8")) === licence;
  if (!same) {
    console.error("three.min.js.gz or three-LICENSE is not what bundle.mjs makes: run npm ci && npm run build");
    process.exit(1);
  }
} else {
  await writeFile(packed, gzipSync(script, { level: 9 }));
  await writeFile(kept, licence);
  console.log(`three.min.js: ${script.length} bytes`);
}
