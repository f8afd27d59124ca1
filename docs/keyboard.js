// Reaches by the keyboard what the mouse reaches in the book: wide tables and blocks of code scroll, and the sidebar opens.
"use strict";

(() => {
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
