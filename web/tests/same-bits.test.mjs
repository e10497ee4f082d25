// The engine in wasm gives the same bits as the native program.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { initSync, Testbed } from '../generated/ishigaki.js';

const program = process.env.ISHIGAKI_BIN;
const STEPS = 600;
/** Boxes; round bodies and hulls' neighbors; joints with limits. */
const SCENES = [
  ['pyramid', { base: 6 }],
  ['pile', { n: 40 }],
  ['ragdolls', { n: 2 }],
];

initSync({ module: readFileSync(new URL('../generated/ishigaki_bg.wasm', import.meta.url)) });

for (const [name, parameters] of SCENES) {
  test(`${name}: ${STEPS} steps leave the same state as the native program`, () => {
    assert.ok(program, 'ISHIGAKI_BIN names the native program; `cargo xtask test` sets it');
    const given = Object.entries(parameters).flatMap(([key, value]) => ['--param', `${key}=${value}`]);
    const output = execFileSync(program, ['run', name, ...given, '--steps', String(STEPS), '--json', '--quiet']);
    const native = JSON.parse(output).state_hash;
    const testbed = Testbed.named(name, JSON.stringify(parameters));
    const { dt } = JSON.parse(testbed.about());
    for (let i = 0; i < STEPS; i++) testbed.step(dt);
    assert.equal(testbed.stateHash(), native);
    testbed.free();
  });
}
