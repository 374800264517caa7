--- The man page ylm(1), from the texts that `ylm COMMAND --help` prints.

local options = require "ylm.cli.options"
local status = require "ylm.cli.status"

local manual = {}

--- Text as troff takes it: hyphens are those of command lines, no line is a request.
local function escaped(text)
  text = text:gsub("\\", "\\e"):gsub("%-", "\\-"):gsub("^([.'])", "\\&%1"):gsub("\n([.'])", "\n\\&%1")
  return text
end

local function bold(text) return "\\fB" .. escaped(text) .. "\\fR" end

--- Lines that stay as they are.
local function block(put, text)
  put ".PP\n.RS 4\n.nf"
  put(escaped((text:gsub("%s+$", ""))))
  put ".fi\n.RE"
end

--- An option with what it is about.
local function option_lines(put, option)
  local words = bold("--" .. option[1])
  if option[2] then words = bold(option[2]) .. ", " .. words end
  if option[3] then words = words .. " \\fI" .. escaped(option[3]) .. "\\fR" end
  put ".TP"
  put(words)
  put(escaped(option[4]))
end

--- The part of a command: usage, options, notes, examples; the words of one that has a text of its own.
local function command_lines(put, row)
  local command = row.command
  put(('.SS "ylm %s"'):format(row.name))
  put(escaped(row.summary))
  if command.text then return block(put, command.text()) end
  put ".PP"
  put(bold("ylm " .. row.name) .. " " .. escaped((command.usage:gsub("%s+", " "))))
  for _, option in ipairs(row.options) do option_lines(put, option) end
  if command.notes then
    put ".PP"
    put(escaped(command.notes))
  end
  if command.examples then block(put, table.concat(command.examples, "\n")) end
end

--- The page, of that version.
function manual.text(version)
  local lines = {}
  local function put(text) lines[#lines + 1] = text end
  put '.\\" Made by lua/ylm/cli/manual.lua: make install'
  put(('.TH YLM 1 "" "ylm %s" "User Commands"'):format(version))
  put ".SH NAME\nylm \\- spherical\\-harmonic lighting"
  put ".SH SYNOPSIS\n.B ylm\n.I COMMAND\n\\&...\n.br\n.B ylm help\n.RI [ WORD ]"
  put ".SH COMMANDS"
  for _, row in ipairs(options.read()) do command_lines(put, row) end
  put ".SH EXIT STATUS"
  put(escaped((status.text:gsub("%s*\n%s*", " "))))
  put ".SH SEE ALSO"
  put(bold "ylm help all" .. " lists forms, functions and methods of the Lua module; " .. bold "ylm help"
    .. " \\fIWORD\\fR describes one.")
  return table.concat(lines, "\n") .. "\n"
end

return manual
