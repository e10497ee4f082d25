// What a region of a screenshot looks like: how light it is, and how much it varies.

/** A screenshot of an element, measured by the page's own decoder. */
export async function picture(page, selector) {
  const png = (await page.locator(selector).screenshot({ timeout: 120000 })).toString('base64');
  const { width, height, light } = await page.evaluate(async (data) => {
    const image = new Image();
    image.src = `data:image/png;base64,${data}`;
    await image.decode();
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext('2d');
    context.drawImage(image, 0, 0);
    const pixels = context.getImageData(0, 0, image.width, image.height).data;
    const lights = [];
    for (let i = 0; i < pixels.length; i += 4) lights.push((0.3 * pixels[i] + 0.59 * pixels[i + 1] + 0.11 * pixels[i + 2]) / 255);
    return { width: image.width, height: image.height, light: lights };
  }, png);
  return {
    /** By parts of width and height. Mean lightness in [0, 1], and its standard deviation. */
    region(left, top, right, bottom) {
      const values = [];
      for (let y = Math.floor(top * height); y < bottom * height; y++) {
        for (let x = Math.floor(left * width); x < right * width; x++) values.push(light[y * width + x]);
      }
      const mean = values.reduce((sum, v) => sum + v, 0) / values.length;
      const spread = Math.sqrt(values.reduce((sum, v) => sum + (v - mean) ** 2, 0) / values.length);
      return { light: mean, spread };
    },
  };
}
