-- Runs `ylm codegen` without the rest of ylm: the generator has to work before anything is built.
os.exit(require("ylm.codegen.main").run(arg))
