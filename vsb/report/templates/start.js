// Start the interactive parts of the page.
"use strict";

{
  const held = (name) => {
    const stored = document.getElementById(name);
    return stored && JSON.parse(stored.textContent);
  };
  showValues();
  sortTables();
  const data = held("interactive-data");
  const root = document.getElementById("live");
  if (data) globalThis.interactive = data.kind === "study" ? new InteractiveStudy(data, root) : new InteractiveYear(data, root);
  const motion = held("buoys-data");
  if (motion) globalThis.buoys = new (motion.shapes.outline ? Body : Buoys)(motion, document.getElementById("buoys"));
  const contents = document.querySelector("nav");
  for (const part of [...document.querySelectorAll("section.screen:not([hidden])")].reverse()) {
    const link = document.createElement("a");
    link.href = `#${part.id}`;
    link.textContent = part.querySelector("h2").textContent;
    contents?.prepend(link, " ");
  }
}
