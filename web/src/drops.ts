/** Files that are dropped on a part of the page. */

/** Takes the first file that is dropped; the area has the class `over` while one is above it. */
export function acceptDrops(area: HTMLElement, take: (file: File) => void): void {
  const mark = (isOver: boolean) => area.classList.toggle("over", isOver);
  area.addEventListener("dragover", (event) => {
    event.preventDefault();
    mark(true);
  });
  area.addEventListener("dragleave", () => mark(false));
  area.addEventListener("drop", (event) => {
    event.preventDefault();
    mark(false);
    const file = event.dataTransfer?.files[0];
    if (file !== undefined) take(file);
  });
}
