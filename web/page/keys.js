// Keys that hold everywhere on the page, whatever has the focus: Space is the red Stop, Escape ends what is under way.
// They are taken before anybody else sees them; a text field keeps its Space.
const kText = "textarea, [contenteditable], input:not([type=range], [type=checkbox], [type=radio], [type=button])";

// stop(isRepeated), where canStop(); end() comes in addition to what else Escape does.
export function listenKeys({ canStop, stop, end }) {
  const take = (event) => {
    const isDown = event.type === "keydown";
    if ((event.code === "Space" || event.key === " ") && canStop() && !event.target.closest?.(kText)) {
      event.preventDefault();  // a focused button is not pressed
      event.stopImmediatePropagation();
      if (isDown) stop(event.repeat);
    } else if (isDown && event.key === "Escape") {
      end();
    }
  };
  for (const type of ["keydown", "keyup"]) addEventListener(type, take, { capture: true });
}
