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
  if (motion) globalThis.buoys = new Buoys(motion, document.getElementById("buoys"));
}
