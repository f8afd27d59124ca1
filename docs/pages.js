// Pages of the book: wide parts scroll by the keyboard, the sidebar opens by it, and tables have room for numbers and sentences.
"use strict";

(() => {
  const WIDE = ".content .table-wrapper, .content pre > code, .content p:has(> img), .content picture, #demo-text, #demo-configuration";
  const NUMBER = /[-+−]?\d[\d.]*e[-−]\d+/g;

  for (const cell of document.querySelectorAll(".content td")) {
    const text = cell.textContent.trim();
    if (text.length > 40) cell.style.minWidth = "14rem";
    keepNumbers(cell);
  }

  /** Numbers such as 1e-5 are not divided at the hyphen. */
  function keepNumbers(cell) {
    const texts = [];
    const walker = document.createTreeWalker(cell, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) texts.push(walker.currentNode);
    for (const text of texts) {
      const numbers = [...text.data.matchAll(NUMBER)];
      // From the last one, so that the places of the others stay.
      for (const { 0: number, index } of numbers.reverse()) {
        const span = document.createElement("span");
        span.style.whiteSpace = "nowrap";
        const rest = text.splitText(index);
        rest.splitText(number.length);
        rest.replaceWith(span);
        span.append(rest);
      }
    }
  }

  function markWideParts() {
    for (const part of document.querySelectorAll(WIDE)) {
      if (part.scrollWidth > part.clientWidth) part.tabIndex = 0;
      else part.removeAttribute("tabindex");
      markEnd(part);
      part.onscroll = () => markEnd(part);
    }
  }
  function markEnd(part) {
    part.toggleAttribute("data-continues", part.scrollLeft + part.clientWidth < part.scrollWidth - 1);
  }
  markWideParts();
  window.addEventListener("load", markWideParts);
  window.addEventListener("resize", markWideParts);

  // Pictures with a dark version follow the theme of the book, and not the setting of the system.
  const root = document.documentElement;
  function choosePictures() {
    const isDark = ["navy", "coal", "ayu"].some((theme) => root.classList.contains(theme));
    for (const source of document.querySelectorAll(".content picture source")) source.media = isDark ? "all" : "not all";
  }
  choosePictures();
  new MutationObserver(choosePictures).observe(root, { attributeFilter: ["class"] });

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
