// Compiles the modules and the library for the Python of the playground:
// node bake.mjs FOLDER_OF_PYODIDE ARCHIVE JOB. The script packs the archive (zip) again, with the
// compiled modules, and with the cache of the harness that the compilation of the job has filled.
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const PACK = `
import compileall, json, os, pathlib, py_compile, sys, zipfile

kept = py_compile.PycInvalidationMode.UNCHECKED_HASH  # the times of unpacked files say nothing
assert compileall.compile_dir("/rcx/harness", quiet=1, invalidation_mode=kept)
sys.path.insert(0, "/rcx/harness")
from rcx_tools.site.drive import Runner

told = json.loads(Runner(pathlib.Path("/cell")).run(job, lambda share: None))
assert "error" not in told, told
with zipfile.ZipFile("/baked.zip", "w", zipfile.ZIP_DEFLATED, compresslevel=9) as packed:
    for file in sorted(pathlib.Path("/rcx").rglob("*")):
        if file.is_file():
            name = zipfile.ZipInfo(file.relative_to("/rcx").as_posix(), (1980, 1, 1, 0, 0, 0))
            name.compress_type = zipfile.ZIP_DEFLATED
            packed.writestr(name, file.read_bytes())
`;

const [folder, archive, job] = process.argv.slice(2);
try {
  const { loadPyodide } = await import(pathToFileURL(`${folder}/pyodide.mjs`));
  const python = await loadPyodide({ env: { HOME: "/home", XDG_CACHE_HOME: "/rcx/cache" } });
  python.unpackArchive(new Uint8Array(readFileSync(archive)), "zip", { extractDir: "/rcx" });
  python.runPython(PACK, { globals: python.toPy({ job: readFileSync(job, "utf8") }) });
  writeFileSync(archive, python.FS.readFile("/baked.zip"));
} catch (error) {
  process.stderr.write(`${error.message}\n`, () => process.exit(1)); // the message only, without the source text
}
