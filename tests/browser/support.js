// What the tests of the page share: the tool, the browser, tables, pixels.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { delimiter, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import puppeteer from 'puppeteer-core';

export const REPOSITORY = fileURLToPath(new URL('../../', import.meta.url));
const TOOL = process.env.HARMOLUX ?? join(REPOSITORY, 'target/release/harmolux');
const SOFTWARE = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
const NO_WEBGL = ['--disable-gpu', '--disable-webgl', '--disable-webgl2', '--disable-3d-apis'];

export const harmolux = (...args) => execFileSync(TOOL, args, { encoding: 'utf8' });

export const newFolder = () => mkdtempSync(join(tmpdir(), 'harmolux-page-'));

function chromium() {
  if (process.env.CHROMIUM) return process.env.CHROMIUM;
  const folders = (process.env.PATH ?? '').split(delimiter);
  const paths = ['chromium', 'chromium-browser', 'google-chrome']
    .flatMap((name) => folders.map((folder) => join(folder, name)));
  const found = paths.find((path) => existsSync(path));
  if (!found) throw new Error('no Chromium on the path: install it or set CHROMIUM');
  return found;
}

/** Starts the browser; `webgl` says whether it has WebGL, drawn by software. */
export const launch = (webgl = true) => puppeteer.launch({
  executablePath: chromium(),
  // The sandbox of Chromium does not run as root.
  args: [...(process.getuid?.() === 0 ? ['--no-sandbox'] : []), ...(webgl ? SOFTWARE : NO_WEBGL)],
});

/** Opens a page from the file system; `faults` collects whatever it must not do. */
export async function open(browser, path, { width = 1280, height = 900, touch = false } = {}) {
  const page = await browser.newPage();
  const faults = [];
  page.on('console', (message) => {
    if (['error', 'warn'].includes(message.type())) faults.push(`console: ${message.text()}`);
  });
  page.on('pageerror', (error) => faults.push(`error: ${error.message}`));
  page.on('dialog', (dialog) => {
    faults.push(`dialog: ${dialog.message()}`);
    dialog.dismiss();
  });
  page.on('request', (request) => {
    if (!/^(file|data):/.test(request.url())) faults.push(`request: ${request.url()}`);
  });
  await page.setViewport({ width, height, hasTouch: touch, isMobile: touch });
  await page.goto(pathToFileURL(path).href);
  await page.waitForFunction('window.harmolux?.ready');
  return { page, faults };
}

/** Waits until a drag has settled and the page is drawn. */
export async function settle(page) {
  await new Promise((resolve) => setTimeout(resolve, 400));
  await page.evaluate(() => new Promise((resolve) => {
    requestAnimationFrame(() => requestAnimationFrame(resolve));
  }));
}

/** Reads a table of numbers and words without quotes; empty cells are null. */
export function readCsv(path) {
  const [head, ...lines] = readFileSync(path, 'utf8').trim().split(/\r?\n/)
    .map((line) => line.split(','));
  const value = (text) => (text === '' ? null : Number.isNaN(Number(text)) ? text : Number(text));
  return lines.map((line) => Object.fromEntries(head.map((name, i) => [name, value(line[i])])));
}

/** The share of the stage whose pixels differ from an earlier picture of it; both as base64. */
export async function changed(page, before, after) {
  return page.evaluate(async (...sources) => {
    const [a, b] = await Promise.all(sources.map(async (source) => {
      const image = new Image();
      image.src = `data:image/png;base64,${source}`;
      await image.decode();
      const { width, height } = image;
      const context = new OffscreenCanvas(width, height).getContext('2d');
      context.drawImage(image, 0, 0);
      return context.getImageData(0, 0, width, height).data;
    }));
    let count = 0;
    for (let i = 0; i < a.length; i += 4) {
      const [red, green, blue] = [0, 1, 2].map((k) => Math.abs(a[i + k] - b[i + k]));
      if (red + green + blue > 12) count++;
    }
    return count / (a.length / 4);
  }, before, after);
}

export async function picture(page) {
  await settle(page);
  return (await page.$('#canvas')).screenshot({ encoding: 'base64' });
}
