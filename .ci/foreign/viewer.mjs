// Renders glTF files of others by Sunstone and by a viewer, three.js in headless Chromium, with the
// same camera and light, and puts the pictures side by side to be looked at. No part of CI.
//
//     node viewer.mjs [--sunstone PROGRAM] [--modules FOLDER] [--size N] [--spp N] [--time SECONDS]
//         [--exposure STOPS] [--traced SAMPLES] [--columns N] [--pictures FOLDER] -o SHEET FILE...
//
// FILE may be followed by `@SECONDS`, a moment of its animations. --modules is the folder in which
// `npm install three puppeteer-core` was run (for --traced also three-gpu-pathtracer and
// three-mesh-bvh); CHROMIUM names the browser. Every cell of the sheet shows Sunstone's picture, the
// viewer's, and how far they are apart (grey: alike; brighter: Sunstone is brighter), and --pictures
// keeps the cells too. A line for every file says the mean difference of the 8-bit values.
//
// Camera and sky are those that Sunstone puts in, as the image's metadata tell them; where a file has
// its own, both use these, and candela and lux, which Sunstone divides by 683 lm/W, are shown 683
// times as bright. Expect the viewer to lack shadows, light from surface to surface, and all that is
// behind or inside of what transmits but the picture of the opaque rest.
import { execFileSync } from "node:child_process";
import { mkdirSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { basename, dirname, extname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { parseArgs } from "node:util";

const LUMENS_PER_WATT = 683;
const { values: given, positionals: files } = parseArgs({
    allowPositionals: true,
    options: {
        sunstone: { type: "string", default: "sunstone" },
        modules: { type: "string", default: "." },
        size: { type: "string", default: "256" },
        spp: { type: "string", default: "64" },
        exposure: { type: "string", default: "-0.6" },
        traced: { type: "string", default: "0" },
        time: { type: "string" },
        columns: { type: "string", default: "3" },
        pictures: { type: "string" },
        output: { type: "string", short: "o" },
    },
});
const size = Number(given.size);
const modules = resolve(given.modules);
const require = createRequire(join(modules, "package.json"));
const { default: puppeteer } = await import(pathToFileURL(require.resolve("puppeteer-core")));

const KINDS = {
    ".js": "text/javascript", ".mjs": "text/javascript", ".html": "text/html",
    ".wasm": "application/wasm", ".png": "image/png", ".webp": "image/webp", ".jpg": "image/jpeg",
    ".jpeg": "image/jpeg",
};
// What the viewer says of itself and not of the file.
const HOUSEKEEPING = /deprecated|renamed|replaced by|KHR_parallel_shader_compile/;
const THREE = "/modules/node_modules/three";
const IMPORTS = {
    "three": `${THREE}/build/three.module.js`,
    "three/examples/": `${THREE}/examples/`,
    "three/": `${THREE}/`,
    "three-mesh-bvh": "/modules/node_modules/three-mesh-bvh/src/index.js",
    "three-gpu-pathtracer": "/modules/node_modules/three-gpu-pathtracer/src/index.js",
};
const PAGE = `<!doctype html><link rel="icon" href="data:,"><script type="importmap">${JSON.stringify({ imports: IMPORTS })}</script>
<script type="module">import { view, traced, cell, sheet } from "/page.mjs";
Object.assign(window, { view, traced, cell, sheet, ready: true });</script>`;

// Serves the page, the modules and the folders of the files, and nothing else of the machine.
function serve(folders) {
    const here = join(dirname(new URL(import.meta.url).pathname), "viewer-page.mjs");
    const server = createServer((request, answer) => {
        const path = decodeURIComponent(request.url.split("?")[0]);
        const [, first, ...rest] = path.split("/");
        const roots = { modules, ...Object.fromEntries(folders.map((it, i) => [`at${i}`, it])) };
        const file = path === "/page.mjs" ? here : first in roots && join(roots[first], ...rest);
        try {
            if (path !== "/" && !(file && statSync(file).isFile())) throw new Error(path);
            answer.setHeader("Content-Type", path === "/" ? "text/html" : KINDS[extname(path)] ?? "application/octet-stream");
            answer.end(path === "/" ? PAGE : readFileSync(file));
        } catch {
            answer.statusCode = 404;
            answer.end();
        }
    });
    return new Promise((done) => server.listen(0, "127.0.0.1", () => done(server)));
}

// What the metadata of an image say of the camera and the sky that were put in.
function putIn(text) {
    const numbers = (words) => words.split(/[ ,]+/).filter(Boolean).map(Number);
    const camera = /put in at \(([^)]*)\), looking along \(([^)]*)\), ([\d.]+) degrees from left to right and ([\d.]+)/.exec(text);
    const sky = /put in: a sky of radiance ([\d.]+), gradient \[([^\]]*)\]/.exec(text);
    return {
        camera: camera && {
            eye: numbers(camera[1]), along: numbers(camera[2]),
            degrees: Math.max(Number(camera[3]), Number(camera[4])),
        },
        sky: sky && { radiance: Number(sky[1]), gradient: numbers(sky[2]) },
    };
}

// Whether a file has lights in candela and lux.
function hasLights(file) {
    const bytes = readFileSync(file);
    const isBinary = bytes.toString("latin1", 0, 4) === "glTF";
    const text = isBinary ? bytes.subarray(20, 20 + bytes.readUInt32LE(12)) : bytes;
    const lights = JSON.parse(text).extensions?.KHR_lights_punctual?.lights ?? [];
    return lights.length > 0;
}

function ours(file, time, scratch) {
    const image = join(scratch, "image.exr"), picture = join(scratch, "image.png");
    const run = (...words) => execFileSync(given.sunstone, words, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
    const moment = time === undefined ? [] : ["--time", String(time)];
    run("render", file, "-o", image, "--width", given.size, "--height", given.size, "--spp", given.spp, "--quiet", ...moment);
    const put = putIn(run("inspect", image));
    const stops = Number(given.exposure) + (!put.sky && hasLights(file) ? Math.log2(LUMENS_PER_WATT) : 0);
    run("visualize", image, "--map", "intensity", "--exposure", String(stops), "-o", picture);
    return { put, url: `data:image/png;base64,${readFileSync(picture).toString("base64")}` };
}

const folders = [...new Set(files.map((it) => dirname(resolve(it.replace(/@[\d.]+$/, "")))))];
// Files may refer to folders above their own.
const roots = folders.map((it) => dirname(it));
const server = await serve(roots);
const scratch = mkdtempSync(join(tmpdir(), "viewer-"));
const browser = await puppeteer.launch({
    executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
    protocolTimeout: 1_800_000,
    args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"],
});
const cells = [];
try {
    for (const word of files) {
        const [, path, moment] = /^(.*?)(?:@([\d.]+))?$/.exec(word);
        const file = resolve(path), time = moment ?? given.time;
        const folder = folders.indexOf(dirname(file));
        const at = [`at${folder}`, basename(folders[folder]), basename(file)].map(encodeURIComponent);
        const page = await browser.newPage();
        const said = [];
        const say = (text) => HOUSEKEEPING.test(text) || said.push(text);
        page.on("console", (it) => ["error", "warn"].includes(it.type()) && say(it.text()));
        page.on("pageerror", (it) => say(String(it)));
        try {
            const { put, url } = ours(file, time, scratch);
            await page.goto(`http://127.0.0.1:${server.address().port}/`);
            await page.waitForFunction("window.ready === true", { timeout: 60_000 });
            const job = { url: `/${at.join("/")}`, size, time: time && Number(time), exposure: Number(given.exposure), ...put };
            const theirs = await page.evaluate((it) => window.view(it), job);
            const more = Number(given.traced) > 0
                ? [await page.evaluate((it, n) => window.traced(it, n), job, Number(given.traced))] : [];
            const label = time === undefined ? basename(file) : `${basename(file)} at ${time} s`;
            const cell = await page.evaluate((...it) => window.cell(...it), label, [url, theirs, ...more], size);
            console.log(`${cell.difference.toFixed(2)}\t${file}`);
            cells.push(cell.url);
            if (given.pictures) {
                mkdirSync(given.pictures, { recursive: true });
                const name = `${String(cells.length).padStart(3, "0")}-${basename(file)}.png`;
                writeFileSync(join(given.pictures, name), Buffer.from(cell.url.split(",")[1], "base64"));
            }
        } catch (error) {
            console.log(`failed\t${file}\t${String(error.stderr || error).trim().slice(0, 400)}`);
        }
        for (const text of new Set(said)) console.log(`\tthe viewer says: ${text.slice(0, 200)}`);
        await page.close();
    }
    if (given.output && cells.length > 0) {
        const page = await browser.newPage();
        await page.goto(`http://127.0.0.1:${server.address().port}/`);
        await page.waitForFunction("window.ready === true");
        const url = await page.evaluate((...it) => window.sheet(...it), cells, Number(given.columns));
        writeFileSync(given.output, Buffer.from(url.split(",")[1], "base64"));
    }
} finally {
    await browser.close();
    server.close();
    rmSync(scratch, { recursive: true });
}
