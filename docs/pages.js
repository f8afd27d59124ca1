// Pages of the book: wide parts scroll by the keyboard, the sidebar opens by it, and tables have room for numbers and sentences.
"use strict";

(() => {
  const WIDE = ".content .table-wrapper, .content pre > code, .content p:has(> img)";

  for (const cell of document.querySelectorAll(".content td")) {
    const text = cell.textContent.trim();
    if (/^[-+−]?[\d.]+e[-−]\d+$/.test(text)) cell.style.whiteSpace = "nowrap";
    else if (text.length > 40) cell.style.minWidth = "14rem";
  }

  function markWideParts() {
    for (const part of document.querySelectorAll(WIDE)) {
      if (part.scrollWidth > part.clientWidth) part.tabIndex = 0;
      else part.removeAttribute("tabindex");
    }
  }
  markWideParts();
  window.addEventListener("load", markWideParts);
  window.addEventListener("resize", markWideParts);

  // mdBook makes this button from a label.
  const sidebar = document.getElementById("sidebar-toggle");
  if (sidebar) {
    sidebar.setAttribute("role", "button");
    sidebar.tabIndex = 0;
    sidebar.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      sidebar.click();
    });
  }
})();
