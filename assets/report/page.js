// SPDX-FileCopyrightText: 2026 The Sightline authors
// SPDX-License-Identifier: GPL-3.0-or-later
'use strict';

// Light and dark: as the system says until the reader says otherwise.
const systemDark = matchMedia('(prefers-color-scheme: dark)');
const themeListeners = [];

function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === 'dark' : systemDark.matches;
}

function onThemeChange(listener) {
  themeListeners.push(listener);
}

function themeChanged() {
  themeListeners.forEach((listener) => listener());
}

systemDark.addEventListener('change', themeChanged);
document.getElementById('theme').addEventListener('click', () => {
  document.documentElement.dataset.theme = isDark() ? 'light' : 'dark';
  themeChanged();
});

// On paper nothing can be opened; the data of charts would fill books.
addEventListener('beforeprint', () => {
  document.querySelectorAll('details:not(.data)').forEach((details) => { details.open = true; });
});
