// Pages of the book: wide parts scroll by the keyboard, the sidebar opens by it, and numbers in tables stay on one line.
"use strict";

(() => {
  for (const cell of document.querySelectorAll(".content td")) {
    if (/^[-+−]?[\d.]+e[-−]\d+$/.test(cell.textContent.trim())) cell.style.whiteSpace = "nowrap";
  }

  function markWideParts() {
    for (const part of document.querySelectorAll(".content .table-wrapper, .content pre > code")) {
      if (part.scrollWidth > part.clientWidth) part.tabIndex = 0;
      else part.removeAttribute("tabindex");
    }
  }
  markWideParts();
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
