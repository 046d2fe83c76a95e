// Shows the charts of each figure in place of its drawing, and switches runs and seeds on and off.
const theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "default";
for (const charts of document.querySelectorAll(".charts")) {
  const drawing = charts.nextElementSibling;
  const names = ["run", "seed"].filter((name) => charts.querySelector(`[name=${name}]`));
  const chosen = (name) => [...charts.querySelectorAll(`[name=${name}]:checked`)].map(({ value }) => (name === "seed" ? Number(value) : value));
  charts.hidden = false;
  const panels = [...charts.querySelectorAll(".chart")];
  Promise.all(panels.map(async (panel) => vegaEmbed(panel, JSON.parse(await unpacked(panel.previousElementSibling.textContent)), { actions: false, renderer: "svg", tooltip: { theme } })))
    .then((shown) => {
      drawing.hidden = true;
      // The chart has a name as a whole; Vega's names of its parts would be read one by one.
      for (const picture of charts.querySelectorAll(".chart svg")) picture.setAttribute("aria-hidden", "true");
      charts.addEventListener("change", () => {
        for (const { view } of shown) {
          for (const name of names) view.signal(`${name}s`, chosen(name));
          view.runAsync();
        }
      });
    })
    .catch((error) => { charts.hidden = true; console.error(error); });
}
