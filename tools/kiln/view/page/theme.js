// Light or dark colours: as in the system, or as chosen with the button. The choice stays in the browser.

const kKey = 'kiln-theme';
const kThemes = { auto: ['Auto', 'as those of the system'], light: ['Light', 'always light'], dark: ['Dark', 'always dark'] };

function remembered() {
  try {
    const name = localStorage.getItem(kKey);
    return name in kThemes ? name : 'auto';
  } catch {
    return 'auto'; // the browser keeps nothing for this page
  }
}

export function startTheme(button) {
  let theme = remembered();
  const show = () => {
    document.documentElement.dataset.theme = theme;
    button.textContent = kThemes[theme][0];
    button.setAttribute('aria-label', `${kThemes[theme][0]}: colours of the page ${kThemes[theme][1]}`);
  };
  button.addEventListener('click', () => {
    const names = Object.keys(kThemes);
    theme = names[(names.indexOf(theme) + 1) % names.length];
    try {
      localStorage.setItem(kKey, theme);
    } catch {
      // The choice lasts until the page is closed.
    }
    show();
  });
  show();
}
