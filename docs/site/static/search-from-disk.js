/* A browser reads no file beside a page that was opened from disk, so excerpts come from a script with all texts. */
if (location.protocol === "file:" && window.textsOfPages) {
  window.fetch = (address) => {
    const path = new URL(address, location.href).pathname;
    const page = Object.keys(textsOfPages).find((name) => path.endsWith(`/${name}`));
    const main = document.createElement("div");
    main.setAttribute("role", "main");
    main.textContent = page ? textsOfPages[page] : "";
    return Promise.resolve({ text: () => Promise.resolve(main.outerHTML) });
  };
}
