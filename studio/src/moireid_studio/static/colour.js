// The usual colours and the picker of a field of colour: they write into the field of text, which works without them.
for (const root of document.querySelectorAll("[data-colour]")) {
  const [field, picker] = root.querySelectorAll("input"), swatches = [...root.querySelectorAll("button")];
  const pen = document.createElement("canvas").getContext("2d");

  const show = () => {
    const words = field.value.trim().toLowerCase();
    for (const one of swatches) one.setAttribute("aria-pressed", String(one.value === words));
    if (CSS.supports("color", words)) {
      pen.fillStyle = words;
      picker.value = pen.fillStyle;
    }
  };
  const write = (colour) => {
    field.value = colour;
    show();
  };

  for (const one of swatches) one.addEventListener("click", () => write(field.value === one.value ? "" : one.value));
  picker.addEventListener("input", () => write(picker.value));
  field.addEventListener("input", show);
  root.querySelector(".swatches").hidden = false;
  show();
}
