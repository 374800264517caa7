--- Completions of command lines by bash, zsh and fish, from the options that `ylm COMMAND --help` prints.

local options = require "ylm.cli.options"

local completions = {}

local function quoted(text) return "'" .. text:gsub("'", "'\\''") .. "'" end

--- The words of an option on a command line: "--output", "-o".
local function words_of(option)
  local list = { "--" .. option[1] }
  if option[2] then list[2] = option[2] end
  return list
end

--- Words after `ylm help`: commands, and all names that it knows.
local function help_words(all, names)
  local list = {}
  for i, command in ipairs(all) do list[i] = command.name end
  for _, name in ipairs(names) do list[#list + 1] = name end
  return list
end

-- bash --------------------------------------------------------------------------------

local BASH = [[
# Completions of ylm for bash, made by lua/ylm/cli/completions.lua: make install
_ylm() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} options= plain=
  COMPREPLY=()
  if [ "$COMP_CWORD" -eq 1 ]; then
    COMPREPLY=($(compgen -W '@COMMANDS@' -- "$word"))
    return
  fi
  case ${COMP_WORDS[1]} in
@CASES@  esac
  case " $plain " in *" $before "*) compopt +o default; return ;; esac
  case $word in -*) COMPREPLY=($(compgen -W "$options" -- "$word")) ;; esac
}
complete -o default -F _ylm ylm
]]

--- The case of a command: its options, those whose value is no file, and values to choose from.
local function bash_case(command)
  local all, plain, out = {}, {}, {}
  for _, option in ipairs(command.options) do
    local choices = options.choices(option)
    for _, word in ipairs(words_of(option)) do
      all[#all + 1] = word
      if option[3] and not options.is_file(option) and not choices then plain[#plain + 1] = word end
    end
    if choices then
      out[#out + 1] = ("      case $before in %s) COMPREPLY=($(compgen -W %s -- \"$word\")); return ;; esac"):format(
        table.concat(words_of(option), "|"), quoted(table.concat(choices, " ")))
    end
  end
  table.insert(out, 1, ("    %s)\n      options=%s plain=%s"):format(command.name, quoted(table.concat(all, " ")),
    quoted(table.concat(plain, " "))))
  return table.concat(out, "\n")
end

--- The file of bash for commands `all`; `names` are those that help knows.
local function bash(all, names)
  local commands, cases = {}, {}
  for i, command in ipairs(all) do
    commands[i] = command.name
    local case = bash_case(command)
    if command.name == "help" then
      local words = quoted(table.concat(help_words(all, names), " "))
      case = case .. ("\n      COMPREPLY=($(compgen -W %s -- \"$word\"))"):format(words)
    end
    cases[i] = case .. " ;;\n"
  end
  local values = { COMMANDS = table.concat(commands, " "), CASES = table.concat(cases) }
  return (BASH:gsub("@(%u+)@", values))
end

-- zsh ---------------------------------------------------------------------------------

local ZSH = [[
#compdef ylm
# Completions of ylm for zsh, made by lua/ylm/cli/completions.lua: make install
_ylm() {
  local -a commands words_of_help
  commands=(
@COMMANDS@  )
  if (( CURRENT == 2 )); then
    _describe 'command' commands
    return
  fi
  shift words
  (( CURRENT-- ))
  case $words[1] in
@CASES@  esac
}
_ylm "$@"
]]

--- An option for _arguments.
local function zsh_option(option)
  local words, action = words_of(option), ""
  local about = option[4]:gsub("[%[%]\\]", "\\%0"):gsub(":", "\\:")
  if option[3] then
    local choices = options.choices(option)
    action = ":" .. option[3]:gsub("[:|]", " ") .. ":" .. (options.is_file(option) and "_files"
      or choices and "(" .. table.concat(choices, " ") .. ")" or " ")
  end
  local last = quoted("[" .. about .. "]" .. action)
  if not words[2] then return words[1] .. last end
  return ("%s{%s}%s"):format(quoted("(" .. table.concat(words, " ") .. ")"), table.concat(words, ","), last)
end

--- The file of zsh.
local function zsh(all, names)
  local commands, cases = {}, {}
  for i, command in ipairs(all) do
    commands[i] = "    " .. quoted(command.name .. ":" .. command.summary:gsub(":", "\\:")) .. "\n"
    local lines = {}
    for k, option in ipairs(command.options) do lines[k] = "        " .. zsh_option(option) .. " \\" end
    local rest = "'*:file:_files'"
    if command.name == "help" then
      rest = quoted("*:word:(" .. table.concat(help_words(all, names), " "):gsub(":", "\\:") .. ")")
    end
    lines[#lines + 1] = "        " .. rest .. " ;;\n"
    cases[i] = ("    %s)\n      _arguments \\\n%s"):format(command.name, table.concat(lines, "\n"))
  end
  local values = { COMMANDS = table.concat(commands), CASES = table.concat(cases) }
  return (ZSH:gsub("@(%u+)@", values))
end

-- fish --------------------------------------------------------------------------------

local function fish_quoted(text) return "'" .. text:gsub("[\\']", "\\%0") .. "'" end

--- A line of fish for an option of the command `name`.
local function fish_option(name, option)
  local choices = options.choices(option)
  local line = { ("complete -c ylm -n '__fish_seen_subcommand_from %s'"):format(name), "-l " .. option[1] }
  if option[2] then line[#line + 1] = "-s " .. option[2]:sub(2) end
  if choices then line[#line + 1] = "-x -a " .. fish_quoted(table.concat(choices, " "))
  elseif option[3] then line[#line + 1] = options.is_file(option) and "-r -F" or "-x" end
  if option[4] ~= "" then line[#line + 1] = "-d " .. fish_quoted(option[4]) end
  return table.concat(line, " ")
end

--- The file of fish.
local function fish(all, names)
  local out = { "# Completions of ylm for fish, made by lua/ylm/cli/completions.lua: make install" }
  for _, command in ipairs(all) do
    out[#out + 1] = ("complete -c ylm -n __fish_use_subcommand -f -a %s -d %s"):format(command.name,
      fish_quoted(command.summary))
    for _, option in ipairs(command.options) do out[#out + 1] = fish_option(command.name, option) end
    if command.name == "help" then
      out[#out + 1] = ("complete -c ylm -n '__fish_seen_subcommand_from help' -f -a %s"):format(
        fish_quoted(table.concat(help_words(all, names), " ")))
    end
  end
  return table.concat(out, "\n") .. "\n"
end

--- Texts of the three files, by shell; `names` are those that ylm help knows.
function completions.texts(names)
  local all = options.read()
  return { bash = bash(all, names), zsh = zsh(all, names), fish = fish(all, names) }
end

return completions
