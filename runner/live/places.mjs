// Where things stand: the diagram of a report in its live part, a diagram above the plots or beside them.

const NARROW = 0.6; // of the page: a diagram that is no wider stands beside the plots
const AROUND = 26; // pixels around a diagram

/** Take the diagram of a report into its live part, and put what the report says first after that.
 * @param {HTMLElement} place @param {HTMLElement} map */
export function takeIn(place, map) {
  const drawing = document.querySelector("svg.proofmass")?.parentElement, section = drawing?.closest("section");
  const before = [...(place.parentElement?.children ?? [])].filter((one) => one.matches("h1 ~ *:has(~ #live)"));
  place.after(...before);
  if (!drawing) return;
  map.append(drawing);
  section?.remove();
}

/** Put a diagram that is narrow beside the plots, a wide one above them. @param {HTMLElement} place */
export function arrange(place) {
  const width = place.querySelector("svg.proofmass")?.getAttribute("width"), wide = Number(width) + AROUND;
  const beside = width && wide <= NARROW * place.clientWidth;
  place.classList.toggle("beside", Boolean(beside));
  place.style.setProperty("--map", beside ? `${wide}px` : "");
}
