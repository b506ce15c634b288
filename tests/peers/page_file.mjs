// A map folder as one file, opened from disk, in a browser.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { desktop, drawn, findColor, findImage, firefox, freeDay, occupiedDay, open, press, text, three, until } from "./browser.mjs";
import { cubesApart_m, postsApart_m, writeFolder } from "./page_folder.mjs";

// body(url) of such a file.
export async function withFile(marcoExport, body) {
  const folder = await mkdtemp(`${tmpdir()}/marco_page_`);
  try {
    await writeFolder(folder);
    execFileSync(marcoExport, [folder, "--html", `${folder}/map.html`]);
    await body(`file://${folder}/map.html`);
  } finally {
    await rm(folder, { recursive: true });
  }
}

export const fileCases = (browser, marcoExport) => ({
  async "one file from disk: without network, a distance is the world's within 1 cm"() {
    await withFile(marcoExport, async (url) => {
      const page = await open(browser, url, { viewport: desktop });
      await page.setOfflineMode(true);
      await page.reload();
      await until("the plan", async () => (await findColor(page, "#map", freeDay)).count > 1000);
      assert.match(await text(page, "#panel-map"), /The map is doubtful[^]*<b>bent<\/b> here[^]*forbid_loop 1 2/);
      await page.keyboard.press("Tab");
      for (const turned of [false, true]) {
        if (turned) await turnMap(page);
        await press(page, "Measure a distance");
        for (const end of [0, 1]) await clickPost(page, end);
        const said = Number((await text(page, ".said")).replace(" m", ""));
        assert.ok(Math.abs(said - postsApart_m) <= 0.01, `${said} m is not ${postsApart_m.toFixed(3)} m`);
        console.log(`  measured ${said} m, the world has ${postsApart_m.toFixed(4)} m`);
        await press(page, "Measure a distance");
      }
      assert.deepEqual(page.faults, []);
    });
  },

  async "one file from disk: the model, measured"() {
    if (firefox || !existsSync(three)) return console.log("  SKIPPED: no WebGL, or no three.js (Debian: libjs-three)");
    await withFile(marcoExport, async (url) => {
      const page = await open(browser, url);
      await press(page, "3D model");
      await page.waitForSelector("#space .controls:not([hidden])");
      await press(page, "Measure a distance");
      for (const rgb of [[190, 0, 0], [0, 0, 190]]) {
        const cube = await until("a cube", async () => {
          const found = await findImage(page, rgb);
          return found.count > 20 ? found : null;
        });
        await page.mouse.click(cube.x, cube.y);
      }
      const said = Number((await text(page, ".said")).replace(" m", ""));
      assert.ok(Math.abs(said - cubesApart_m) < 0.1, `${said} m is not ${cubesApart_m.toFixed(2)} m`);
      await press(page, "Walk");
      await drawn(page);
      assert.deepEqual(page.faults, []);
    });
  },
});

// To the nearer or the farther post: at the wheel's closest, its middle is a pixel of a few millimetres.
async function clickPost(page, end) {
  await press(page, "Show all");
  await drawn(page);
  const split = desktop.width / 2 + 140, half = end === 0 ? [372, 72, split, 900] : [split, 72, 1440, 900];
  let post = await findColor(page, "#map", occupiedDay, half);
  for (let i = 0; i < 6; ++i) {
    await page.mouse.move(post.x, post.y);
    await page.mouse.wheel({ deltaY: -200 });
    await drawn(page);
    const near = [post.x - 120, post.y - 120, post.x + 120, post.y + 120];
    post = await findColor(page, "#map", occupiedDay, near);
  }
  await page.mouse.click(post.x, post.y);
}

async function turnMap(page) {
  await page.keyboard.down("Shift");
  await page.mouse.move(800, 700);
  await page.mouse.wheel({ deltaY: 90 });
  await page.keyboard.up("Shift");
}
