/* SPDX-License-Identifier: MIT */
/* What the benches of the viewer have in common: the words of their command lines, BUILD-FOLDER [FILE] [--NAME NUMBER] ..., and the harness
 * of the page's tests. */

import path from 'node:path';
import { fileURLToPath } from 'node:url';

/** What the tests' harness exports, the file, and the numbers: those given here where the command line has no others. */
export async function begin(numbers) {
    const root = path.join(path.dirname(fileURLToPath(import.meta.url)), '..'),
        words = process.argv.slice(2);
    const told = Object.entries(numbers).map(([name, fallback]) => [
        name,
        words.includes(`--${name}`) ? Number(words.splice(words.indexOf(`--${name}`), 2)[1]) : fallback,
    ]);
    const [build = 'build', given] = words;
    /* The harness of the tests reads its three words from the command line. */
    process.argv.splice(2, Infinity, path.resolve(build, 'tools/pellucid'), root, path.resolve(build, 'tests/web/packages'));
    const harness = await import('../tests/web/harness.mjs');
    return { ...harness, ...Object.fromEntries(told), file: given ?? path.join(harness.data, 'aneurism.nrrd') };
}
