// Errors that npm's gltf-validator finds in each file, one line each: `count path`. The package is
// looked for from the current folder.
import { createRequire } from "node:module";
import fs from "node:fs";
import path from "node:path";

const validator = createRequire(path.join(process.cwd(), "x.js"))("gltf-validator");
for (const file of process.argv.slice(2)) {
    const beside = (uri) => new Promise((resolve, reject) => {
        const place = path.resolve(path.dirname(file), decodeURIComponent(uri));
        fs.readFile(place, (error, data) => (error ? reject(error.message) : resolve(data)));
    });
    let count = "unreadable";
    try {
        const options = { uri: path.basename(file), externalResourceFunction: beside };
        const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), options);
        count = report.issues.numErrors;
    } catch {
        // What is no glTF at all has no report.
    }
    console.log(`${count} ${file}`);
}
