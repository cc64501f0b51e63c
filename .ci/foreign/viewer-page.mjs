// What viewer.mjs does in the browser.
import * as THREE from "three";
import { DRACOLoader } from "three/examples/jsm/loaders/DRACOLoader.js";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";

// Samples of a pixel along each side.
const FINE = 2;

// A sky of a radiance times 1 + direction . gradient, as an equirectangular picture.
function equirectangular({ radiance, gradient }) {
    const [width, height] = [256, 128];
    const data = new Float32Array(4 * width * height);
    for (let y = 0; y < height; y++) {
        const up = Math.PI * ((y + 0.5) / height - 0.5);
        for (let x = 0; x < width; x++) {
            const around = 2 * Math.PI * ((x + 0.5) / width - 0.5);
            const direction = [Math.cos(up) * Math.cos(around), Math.sin(up), Math.cos(up) * Math.sin(around)];
            const dot = direction.reduce((sum, it, i) => sum + it * gradient[i], 0);
            const value = radiance * (1 + dot);
            data.set([value, value, value, 1], 4 * (y * width + x));
        }
    }
    const texture = new THREE.DataTexture(data, width, height, THREE.RGBAFormat, THREE.FloatType);
    texture.mapping = THREE.EquirectangularReflectionMapping;
    texture.minFilter = texture.magFilter = THREE.LinearFilter;
    texture.wrapS = THREE.RepeatWrapping;
    texture.needsUpdate = true;
    return texture;
}

// The scene of a file at a moment, the camera by which it is seen, and its light.
async function load({ url, time, camera, sky }) {
    const loader = new GLTFLoader();
    loader.setDRACOLoader(new DRACOLoader().setDecoderPath("/modules/node_modules/three/examples/jsm/libs/draco/"));
    const gltf = await loader.loadAsync(url);
    const scene = new THREE.Scene();
    scene.add(gltf.scene);
    if (time !== undefined) {
        const mixer = new THREE.AnimationMixer(gltf.scene), moved = new Set();
        for (const clip of gltf.animations) {
            // Of animations that move the same, the first is played.
            if (clip.tracks.every((it) => moved.has(it.name))) continue;
            clip.tracks.forEach((it) => moved.add(it.name));
            const action = mixer.clipAction(clip);
            action.setLoop(THREE.LoopOnce);
            action.clampWhenFinished = true;
            action.play();
        }
        mixer.setTime(time);
    }
    scene.updateMatrixWorld(true);
    let eye = null;
    gltf.scene.traverse((it) => { eye ??= it.isCamera ? it : null; });
    if (camera) {
        const box = new THREE.Box3().setFromObject(scene);
        const place = new THREE.Vector3(...camera.eye);
        const radius = box.getSize(new THREE.Vector3()).length() / 2;
        const distance = box.getCenter(new THREE.Vector3()).distanceTo(place);
        const near = Math.max(distance - 1.5 * radius, 1e-3 * radius);
        eye = new THREE.PerspectiveCamera(camera.degrees, 1, near, distance + 1.5 * radius);
        eye.position.copy(place);
        eye.lookAt(place.clone().add(new THREE.Vector3(...camera.along)));
        eye.updateMatrixWorld(true);
    } else if (eye.isPerspectiveCamera) {
        eye.aspect = 1;
    } else {
        eye.left = -eye.top;
        eye.right = eye.top;
    }
    eye.updateProjectionMatrix();
    if (sky) {
        scene.environment = scene.background = equirectangular(sky);
    } else {
        scene.background = new THREE.Color(0);
    }
    return { scene, eye };
}

function rendererOf(side, exposure) {
    const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true, antialias: true });
    renderer.setSize(side, side, false);
    // Linear but for the exposure: values beyond 1 are clipped.
    renderer.toneMapping = THREE.LinearToneMapping;
    renderer.toneMappingExposure = 2 ** exposure;
    return renderer;
}

const toLinear = Float32Array.from({ length: 256 }, (_, i) =>
    i / 255 <= 0.04045 ? i / 255 / 12.92 : ((i / 255 + 0.055) / 1.055) ** 2.4);
const toCode = (it) => 255 * (it <= 0.0031308 ? 12.92 * it : 1.055 * it ** (1 / 2.4) - 0.055);

// A canvas at a whole part of its size: means of linear values.
function smaller(canvas, times) {
    const [width, height] = [canvas.width / times, canvas.height / times];
    const [from, to] = [canvasOf(canvas.width, canvas.height), canvasOf(width, height)];
    from.context.drawImage(canvas, 0, 0);
    const fine = from.context.getImageData(0, 0, canvas.width, canvas.height).data;
    const coarse = to.context.createImageData(width, height);
    for (let y = 0; y < height; y++) for (let x = 0; x < width; x++) for (let c = 0; c < 3; c++) {
        let sum = 0;
        for (let j = 0; j < times; j++) for (let i = 0; i < times; i++) {
            sum += toLinear[fine[4 * ((y * times + j) * canvas.width + x * times + i) + c]];
        }
        coarse.data[4 * (y * width + x) + c] = Math.round(toCode(sum / times ** 2));
        coarse.data[4 * (y * width + x) + 3] = 255;
    }
    to.context.putImageData(coarse, 0, 0);
    return to.canvas;
}

function canvasOf(width, height) {
    const canvas = document.createElement("canvas");
    Object.assign(canvas, { width, height });
    return { canvas, context: canvas.getContext("2d", { willReadFrequently: true }) };
}

// The viewer's picture.
export async function view(job) {
    const { scene, eye } = await load(job);
    const renderer = rendererOf(FINE * job.size, job.exposure);
    await renderer.compileAsync(scene, eye);
    renderer.render(scene, eye);
    return smaller(renderer.domElement, FINE).toDataURL();
}

// That of a path tracer in it, by so many samples a pixel.
export async function traced(job, samples) {
    const { WebGLPathTracer } = await import("three-gpu-pathtracer");
    const { scene, eye } = await load(job);
    const renderer = rendererOf(job.size, job.exposure);
    const tracer = new WebGLPathTracer(renderer);
    Object.assign(tracer, { renderDelay: 0, minSamples: 0, fadeDuration: 0, rasterizeScene: false, dynamicLowRes: false, bounces: 10, filterGlossyFactor: 0 });
    tracer.tiles.set(1, 1);
    tracer.setScene(scene, eye);
    while (tracer.samples < samples) {
        tracer.renderSample();
        await new Promise((done) => setTimeout(done));
    }
    return renderer.domElement.toDataURL();
}

async function pictureOf(url) {
    const picture = new Image();
    picture.src = url;
    await picture.decode();
    return picture;
}

// Pictures side by side, and how far the first and the last are apart.
export async function cell(label, urls, size) {
    const text = 16;
    const { canvas, context } = canvasOf((urls.length + 1) * size, size + text);
    context.fillStyle = "#fff";
    context.fillRect(0, 0, canvas.width, canvas.height);
    for (const [i, url] of urls.entries()) {
        // Sunstone magnifies what is small, and writes a legend below.
        const picture = await pictureOf(url), side = picture.width;
        context.drawImage(picture, 0, 0, side, side, i * size, text, size, size);
    }
    const [one, other] = [0, urls.length - 1].map((i) => context.getImageData(i * size, text, size, size));
    let sum = 0;
    for (let i = 0; i < one.data.length; i++) {
        if (i % 4 === 3) continue;
        const apart = one.data[i] - other.data[i];
        sum += Math.abs(apart);
        one.data[i] = 128 + apart;
    }
    context.putImageData(one, urls.length * size, text);
    context.fillStyle = "#000";
    context.font = "12px sans-serif";
    const difference = sum / (3 * size * size);
    context.fillText(`${label}   (${difference.toFixed(1)})`, 4, 12);
    return { url: canvas.toDataURL(), difference };
}

// Cells on a sheet.
export async function sheet(urls, columns) {
    const pictures = await Promise.all(urls.map(pictureOf));
    const [width, height] = [pictures[0].width + 6, pictures[0].height + 4];
    const { canvas, context } = canvasOf(width * Math.min(columns, urls.length), height * Math.ceil(urls.length / columns));
    context.fillStyle = "#fff";
    context.fillRect(0, 0, canvas.width, canvas.height);
    pictures.forEach((it, i) => context.drawImage(it, (i % columns) * width, Math.floor(i / columns) * height));
    return canvas.toDataURL();
}
