// Search of the page of keys: rows whose words contain what is typed, under their sections.
"use strict";

document.addEventListener("DOMContentLoaded", () => {
  const input = document.querySelector("#find-key");
  if (!input) return;
  input.closest("p").hidden = false;
  const rows = [...document.querySelectorAll("article table tbody tr")];
  const sections = [...document.querySelectorAll("article section section")];
  const placeOf = (row) => row.closest("section").querySelector("h2, h3").textContent;
  const words = rows.map((row) => `${placeOf(row)} ${row.textContent}`.toLowerCase());
  input.addEventListener("input", () => {
    const wanted = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    rows.forEach((row, i) => { row.hidden = !wanted.every((word) => words[i].includes(word)); });
    for (const section of sections) section.hidden = ![...section.querySelectorAll("tbody tr")].some((row) => !row.hidden);
    for (const table of document.querySelectorAll("article table")) table.hidden = ![...table.tBodies[0].rows].some((row) => !row.hidden);
    const left = rows.filter((row) => !row.hidden).length;
    document.querySelector("#found-keys").textContent = wanted.length ? `${left} of ${rows.length} keys` : "";
  });
});
