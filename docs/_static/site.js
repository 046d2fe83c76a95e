// What the theme leaves out for readers with a keyboard or a screen reader.
for (const box of document.querySelectorAll("pre, .table-wrapper")) box.tabIndex = 0; // may be scrolled sideways
for (const heading of document.querySelectorAll(".caption[role=heading]")) heading.ariaLevel = 2;
for (const part of document.querySelectorAll("aside")) part.ariaLabel = part.className.split("-")[0]; // sidebar, toc
for (const corner of document.querySelectorAll("th:empty, th:has(> p:empty:only-child)")) corner.outerHTML = "<td></td>";
for (const lines of document.querySelectorAll("dt dl")) // a signature of several lines is no list
  lines.outerHTML = lines.outerHTML.replace(/<(\/?)d[ld]\b/g, "<$1span").replace("<span", '<span class="signature"');
document.getElementById("search-results")?.insertAdjacentHTML("beforebegin", "<h1>Search</h1>");
