// Runs inside a report page, in a frame of a given width, and tells the page around it what is
// wrong: pictures that are missing, text that is cut off or sticks out.
addEventListener("load", () => {
  const wrong = [];
  const width = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth > width) {
    wrong.push(`page is ${document.documentElement.scrollWidth} wide, the window ${width}`);
  }
  for (const image of document.images) {
    if (!image.complete || image.naturalWidth === 0) wrong.push(`image "${image.alt}" is missing`);
    if (image.getBoundingClientRect().width < 100) wrong.push(`image "${image.alt}" is tiny`);
  }
  const pictures = document.querySelectorAll("svg");
  for (const svg of pictures) {
    const frame = svg.getBoundingClientRect();
    const name = svg.querySelector("title").textContent;
    if (frame.width < 100 || frame.height < 20) wrong.push(`picture "${name}" is tiny`);
    if (!svg.querySelector("path, circle")) wrong.push(`picture "${name}" is empty`);
    for (const text of svg.querySelectorAll("text")) {
      const box = text.getBoundingClientRect();
      if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 ||
          box.bottom > frame.bottom + 1) {
        wrong.push(`"${text.textContent}" sticks out of picture "${name}"`);
      }
      if (box.height < 8) wrong.push(`"${text.textContent}" is too small to read`);
    }
  }
  for (const element of document.querySelectorAll("h1, h2, p, li, th, td, dt, dd, figcaption")) {
    const box = element.getBoundingClientRect();
    if (box.left < 0 || box.right > width + 1 || element.scrollWidth > element.clientWidth + 1) {
      wrong.push(`"${element.textContent}" is cut off`);
    }
  }
  for (const element of document.querySelectorAll("tbody th")) {
    const lines = element.getBoundingClientRect().height / parseFloat(getComputedStyle(element).fontSize);
    if (lines > 6) wrong.push(`"${element.textContent}" is squeezed`);
  }
  const found = `${document.images.length} images, ${pictures.length} pictures`;
  parent.postMessage(wrong.length > 0 ? wrong.join("; ") : `good: ${found}`, "*");
});
