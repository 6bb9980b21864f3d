# What tools/gpu_check runs its steps with: a time limit for each, its result, and one JSON of all; to be sourced by bash.
# SPDX-License-Identifier: BSD-3-Clause

# A step is a function. Its output goes to a log; it runs what takes time through `limited`; it returns 0 where all is well and
# 77 where it has nothing to do, and may set `why` (one reason, or the first lines of what failed) and `members` (JSON members).
total_s=480      # for all steps; the limits of the steps are meant for 480 s and grow with it
step_results=()  # "name": {...}
steps_failed=()  # names
why=""
members=""
started_s=$SECONDS

json_string() {
  local text="$1"
  text="${text//\\/\\\\}"
  text="${text//\"/\\\"}"
  text="${text//$'\n'/\\n}"
  printf '"%s"' "$(tr -d '\000-\037' <<<"$text")"
}

# The first lines of a log that tell what went wrong, else its last ones.
first_faults() {
  local log="$1" pattern="${2:-error|fatal|fail|cannot|no such}" lines=""
  [[ -f "$log" ]] || return 0
  lines="$(grep -iE -m 8 -- "$pattern" "$log" | cut -c 1-300)"
  [[ -n "$lines" ]] || lines="$(tail -n 8 "$log" | cut -c 1-300)"
  printf '%s' "$lines"
}

# Runs a command until the step's time is over; its exit code, or 124 then.
limited() {
  local left=$((step_deadline_s - SECONDS))
  ((left > 0)) || return 124
  timeout --kill-after=5 "$left" "$@"
}

# add_result NAME RESULT SECONDS REASON MEMBERS: what print_report will say of a step; RESULT is ok, failed or skipped.
add_result() {
  local text="\"result\": \"$2\", \"seconds\": $3"
  [[ -z "$4" ]] || text+=", \"why\": $(json_string "$4")"
  [[ -z "$5" ]] || text+=", $5"
  step_results+=("\"$1\": {$text}")
  [[ "$2" != failed ]] || steps_failed+=("$1")
  echo "$program: $1: $2 after $3 s${4:+: ${4%%$'\n'*}}" >&2
}

# run_step NAME LIMIT_S FUNCTION: the limit is that of a run with 480 s for all.
run_step() {
  local name="$1" limit_s=$(($2 * total_s / 480)) left_s=$((total_s - SECONDS + started_s)) begin_s=$SECONDS code=0
  step_log="$build/$name.log"
  ((limit_s < left_s)) || limit_s=$left_s
  if ((limit_s < 3)); then
    add_result "$name" failed 0 "no time was left of $total_s s for all steps (--minutes)" ""
    return 1
  fi
  step_deadline_s=$((SECONDS + limit_s))
  why="" members=""
  "$3" >"$step_log" 2>&1 || code=$?
  local seconds=$((SECONDS - begin_s)) over=""
  case "$code" in
    0) add_result "$name" ok "$seconds" "$why" "$members" ;;
    77) add_result "$name" skipped "$seconds" "$why" "$members" ;;
    *)
      ((SECONDS < step_deadline_s)) || over="ran past $limit_s s"$'\n'
      add_result "$name" failed "$seconds" "$over${why:-$(first_faults "$step_log")}" "$members"
      return 1
      ;;
  esac
}

skip_step() { add_result "$1" skipped 0 "$2" ""; }

# print_report OK WHY MEMBERS: the one JSON.
print_report() {
  local i
  printf '{\n"ok": %s,\n"why": %s,\n%s"seconds": %d,\n"steps": {\n' "$1" "$(json_string "$2")" "${3:+$3,$'\n'}" \
    $((SECONDS - started_s))
  for ((i = 0; i < ${#step_results[@]}; ++i)); do
    ((i == 0)) || printf ',\n'
    printf '%s' "${step_results[i]}"
  done
  printf '\n}\n}\n'
}
