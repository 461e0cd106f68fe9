// Begin: what moves shows itself.
"use strict";

{
  const held = (name) => {
    const stored = document.getElementById(name);
    return stored && JSON.parse(stored.textContent);
  };
  showValues();
  sortTables();
  const data = held("living-data");
  const root = document.getElementById("live");
  if (data) globalThis.living = data.kind === "study" ? new LivingStudy(data, root) : new LivingYear(data, root);
  const motion = held("buoys-data");
  if (motion) globalThis.buoys = new Buoys(motion, document.getElementById("buoys"));
}
