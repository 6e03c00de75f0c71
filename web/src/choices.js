// Fills groups of radio buttons and lists with options.

/**
 * Fills a group with radio buttons.
 * @param {HTMLElement} group
 * @param {[string, string][]} options value and name
 * @param {string} chosen
 * @param {(value: string) => void} change
 * @returns {(value: string) => void} selects a value without calling `change`; ignores unknown values
 */
export function radioButtons(group, options, chosen, change) {
  /** @type {Map<string, HTMLInputElement>} */
  const inputs = new Map();
  for (const [value, name] of options) {
    const label = document.createElement('label');
    const input = document.createElement('input');
    input.type = 'radio';
    input.name = group.id;
    input.value = value;
    input.checked = value === chosen;
    input.addEventListener('change', () => change(value));
    label.append(input, name);
    group.append(label);
    inputs.set(value, input);
  }
  return (chosenNow) => {
    for (const [value, input] of inputs) input.checked = value === chosenNow;
  };
}

/**
 * Scrolls a group to its chosen button, where the group is wider than its place.
 * @param {HTMLElement} group
 */
export function showChosen(group) {
  const chosen = group.querySelector('input:checked')?.parentElement;
  if (!chosen) return;
  group.scrollLeft = chosen.offsetLeft - (group.clientWidth - chosen.offsetWidth) / 2;
}

/**
 * Fills a list.
 * @param {HTMLSelectElement} list
 * @param {Record<string, string>} options value and name
 * @param {string} chosen
 * @param {(value: string) => void} change
 */
export function selection(list, options, chosen, change) {
  for (const [value, name] of Object.entries(options)) {
    const option = document.createElement('option');
    option.value = value;
    option.textContent = name;
    option.selected = value === chosen;
    list.append(option);
  }
  list.addEventListener('change', () => change(list.value));
}
