// Day or night: as the system says, unless the user chose.
const kThemes = ["system", "day", "night"];
const dark = matchMedia("(prefers-color-scheme: dark)");

function stored() {
  try {
    const theme = localStorage.getItem("marco-theme");
    return kThemes.includes(theme) ? theme : "system";
  } catch {
    return "system";  // a page from disk may have no storage
  }
}
let theme = stored();

export function applyTheme() {
  document.documentElement.dataset.theme = theme === "system" ? (dark.matches ? "night" : "day") : theme;
  document.dispatchEvent(new Event("themechange"));
}
dark.addEventListener("change", applyTheme);

// @returns what it is now, for the user.
export function nextTheme() {
  theme = kThemes[(kThemes.indexOf(theme) + 1) % kThemes.length];
  try {
    localStorage.setItem("marco-theme", theme);
  } catch {
    // kept for this page only
  }
  applyTheme();
  return { system: "Colours follow the system", day: "Day colours", night: "Night colours" }[theme];
}
