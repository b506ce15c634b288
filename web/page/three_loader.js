// three.js (r111, global THREE) is not ours: the server has Debian's, a page of one file carries it. It comes when 3D is opened.
let loading = null;

// Rejects with a word for the user.
export function loadThree() {
  loading ??= new Promise((resolve, reject) => {
    if (window.THREE) return resolve();
    const script = document.createElement("script"), carried = document.getElementById("three");
    const missing = () => reject(new Error("3D needs three.js, which is not installed (Debian: apt install libjs-three)"));
    if (carried) {
      script.textContent = carried.textContent.replaceAll("<\\/", "</").replaceAll("<\\!--", "<!--");
      document.head.append(script);
      return window.THREE ? resolve() : missing();
    }
    if (document.getElementById("snapshot")) return missing();
    script.src = `page/three.js${location.search}`;
    script.onload = () => (window.THREE ? resolve() : missing());
    script.onerror = missing;
    document.head.append(script);
  });
  return loading;
}
