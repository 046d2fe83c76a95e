// Unpacks and starts the program that shows charts. A browser that cannot do so goes on showing the drawings.
window.unpacked = (packed) => {
  const bytes = Uint8Array.from(atob(packed), (character) => character.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).text();
};
const program = document.createElement("script");
program.type = "module";
program.textContent = await unpacked(document.querySelector("#program").textContent);
document.head.append(program);
