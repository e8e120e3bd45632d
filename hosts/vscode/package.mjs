// Packs the extension: `olp.vsix`, with the project's licence and nothing that was only needed to build it.
import { copyFileSync, rmSync } from "node:fs";
import { createVSIX } from "@vscode/vsce";

copyFileSync("../../LICENSE", "LICENSE");
try {
  // The links of README.md stay as they are: it says no address of a repository.
  await createVSIX({
    packagePath: "olp.vsix",
    dependencies: false,
    allowMissingRepository: true,
    rewriteRelativeLinks: false,
  });
} finally {
  rmSync("LICENSE");
}
