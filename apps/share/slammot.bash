# Completion of slammot: commands, options, and the names that the program itself lists.
_slammot() {
  local word=$2 before=$3 program=${COMP_WORDS[0]} command='' candidates=''
  local i
  for ((i = 1; i < COMP_CWORD; i++)); do
    [[ ${COMP_WORDS[i]} == -* ]] || { command=${COMP_WORDS[i]}; break; }
  done
  compopt +o default
  case $before in
    --estimator) candidates=$("$program" list estimators 2>/dev/null | cut -d' ' -f1) ;;
    --landmark) candidates=$("$program" list landmarks 2>/dev/null | cut -d' ' -f1) ;;
    --scenario) candidates=$("$program" list scenarios 2>/dev/null | cut -d' ' -f1) ;;
    --landmarks) candidates='final every-frame' ;;
    --set) [[ $command == simulate ]] ||
      candidates=$("$program" run --help 2>/dev/null | sed -n '/^Configuration keys/,$s/^  \([a-z][a-z_.]*\)  .*/\1=/p')
      compopt -o nospace ;;
    --output | --config | --against | --sequence | --json | --camera) compopt -o default; return ;;
    *)
      if [[ -z $command || ${COMP_WORDS[COMP_CWORD]} == "$command" ]]; then
        candidates=$("$program" --help 2>/dev/null | sed -n '/^Subcommands:/,$s/^  \([a-z]*\) .*/\1/p')
        candidates+=' --help --version --quiet'
      elif [[ $word == -* ]]; then
        candidates=$("$program" "$command" --help 2>/dev/null | grep -oE '^ +(-h,)?--[a-z-]+' | tr -d ' ' | sed 's/^-h,//')
        candidates+=' --quiet'
      elif [[ $command == list ]]; then
        candidates=$("$program" list --help 2>/dev/null | sed -n 's/.*{\(.*\)}.*/\1/p' | tr ',' ' ')
      elif [[ $command == simulate ]]; then
        candidates=$("$program" list scenarios 2>/dev/null | cut -d' ' -f1)
      else
        compopt -o default
        return
      fi ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$candidates" -- "$word")
}
complete -F _slammot slammot
