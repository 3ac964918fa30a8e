# What the commands of the transcripts beside this file are made of. Each begins in a folder with the plain example.
PLAIN=$PROJECT/tests/data/good/plain
EXAMPLE=$PROJECT/reports/mueller2016
wetcor() { "$WETCOR" "$@"; }
fit() { wetcor fit scene.toml --stages least_squares --out "$@"; }
# the same command with little memory
little() { (ulimit -v 1500000; "$@"); }
# a report in `report`
fitted() { fit report > told.txt; local status=$?; rm told.txt; test $status -le 1; }
# what a line of the same name says of a JSON file, held by a child of the tests
holds() { TRANSCRIPTS_LINE="$*" "$TESTS" --exact transcripts::a_line_of_fields_is_held_in_bash_as_here --nocapture > /dev/null; }
field() { holds field "$@"; }
count() { holds count "$@"; }
predict() { wetcor predict r --particle PTFE --liquid AK10 --diameter-mm 4 --film-um 200 --speed-m-s 0.05:2:4; }
# a prediction at such numbers is a table of numbers, or refused
numbers() {
    wetcor predict r --particle PTFE --speed-m-s 1e-300:1e300:3 "$@" > told.txt 2> said.txt
    test $? = 2 -o "$(wc -l < told.txt)" -gt 3 && ! grep -qiE 'nan|inf' told.txt && ! grep -q panicked said.txt
}
# a fit on five threads, with room for so many quarters of a gigabyte, each of which is the stack of one: what comes of it
# is a file of that name
stacks() {
    (ulimit -v $(((240 + 256 * $1) * 1024)) && fit o --threads 5) > told.txt 2> said.txt
    local status=$?
    if grep -q 'cannot start the 4 threads that the least work takes' said.txt; then
        touch none && test $status = 2
    elif grep -q ' in place of 5 threads: no more could be started' said.txt; then
        touch fewer && test $status -le 1
    else
        touch all && test $status -le 1
    fi
}
# has the scene read another table
reading() { sed -i "s|runs.csv|$1|" scene.toml; }

header() { head -n 1 "$PLAIN/runs.csv"; }
row() { sed -n 2p "$PLAIN/runs.csv"; }
many() { yes "$(row)" | head -n "$1"; }
# a table with a cell of so many bytes in a column that nobody reads
long() {
    { echo "$(header),note"; echo "$(row),x"; echo "$(row),$(head -c "$1" /dev/zero | tr '\0' x)"; echo "$(row),x"; } > runs.csv
}
# so many particles more, each with three dry runs
spheres() {
    seq "$1" | awk '{ printf "\n[particles.Q%d]\ndensity_kg_m3 = 2150\nroughness_um = 5\n", $1 }' >> scene.toml
    seq "$1" | awk '{ printf "Q%d,dry,4,,,0.5,0.85\nQ%d,dry,4,,,1,0.83\nQ%d,dry,4,,,2,0.80\n", $1, $1, $1 }' >> runs.csv
}

# lines of a scene whose runs are drawn: dry runs that are all alike; a few of both kinds
alike() {
    printf '%s\n' '[truth]' 'dry_k = { PTFE = 0.183 }' 'sigma_dry = 0.0' 'sigma_wet = 0.0' 'lubrication_log = 1.9' \
        'inertial_prefactor = 0.6' '[design]' 'diameter_mm = { PTFE = [4] }' 'dry_impact_speed_m_s = [1]'
}
design() {
    printf '%s\n' '[truth]' 'dry_k = { PTFE = 0.18 }' 'lubrication_log = 1.9' 'inertial_prefactor = 0.6' 'sigma_dry = 0.01' \
        'sigma_wet = 0.01' '[design]' 'diameter_mm = [4.762]' 'liquids = ["AK10"]' 'film_ratio = [0.06]' \
        'impact_speed_m_s = [1.0, 2.0]' 'dry_impact_speed_m_s = [1.0]' 'repeats = 1'
}
# lines of a scene that make its fit slow
slow() {
    printf '%s\n' '[sampler]' 'chains = 4' 'warmup = 100000' 'draws = 100000' '[model]' 'likelihood = "student"'
}

# and lines that make it brief, and as brief as can be
brief() {
    printf '%s\n' '[sampler]' 'chains = 2' 'warmup = 150' 'draws = 100' '[bootstrap]' 'replicates = 200'
}
briefest() { brief | sed 's/= 1[05]0$/= 40/'; }

# a stranger's file in the report; that it is kept, before it is taken out
strange() { mkdir -p "$(dirname "report/$1")"; echo "a week of work" > "report/$1"; }
kept() { test "$(cat "report/$1")" = "a week of work" && rm "report/$1"; }
# a folder that an earlier run left, without a maker who holds its lock: the lock's text and other files
left() {
    local folder=.wetcor-$1
    mkdir "$folder"
    printf %s "$2" > "$folder/lock"
    for file in "${@:3}"; do
        mkdir -p "$(dirname "$folder/$file")"
        echo half > "$folder/$file"
    done
}

# the hand-off of a wet law of the example
handoff() { wetcor handoff "$EXAMPLE" --particle PTFE --liquid AK10 --diameter-mm 4.762 --film-um 286 "$@"; }
# the first block of a language on a page
block() { awk -v fence="\`\`\`$1" '$0 == fence { on = 1; next } on && /^```/ { exit } on' "$PROJECT/docs/$2"; }
# nine runs whose table has a column more, which nobody reads
unread() {
    echo "particle,liquid,diameter_mm,film_um,impact_speed_m_s,e,$1" > runs.csv
    seq 0 8 | awk '{ printf "PE,dry,5,,%d.5,0.7%d,%d\n", 1 + $1 % 2, $1, $1 }' >> runs.csv
    printf '%s\n' '[data]' 'runs = "runs.csv"' 'columns = { restitution = "e" }' '[particles.PE]' 'density_kg_m3 = 940' > scene.toml
}
# nine runs with these columns and cells; a scene with lines of [data] and liquids
liquids() {
    echo "particle,diameter_mm,$1,impact_speed_m_s,restitution" > runs.csv
    seq 0 8 | awk -v cells="$2" '{ printf "PTFE,4,%s,%d.5,0.7%d\n", cells, 1 + $1 % 2, $1 }' >> runs.csv
    printf '%s\n' '[data]' 'runs = "runs.csv"' "$3" '[particles.PTFE]' 'density_kg_m3 = 2150' > scene.toml
    for liquid in "${@:4}"; do
        printf '%s\n' "[liquids.$liquid]" 'density_kg_m3 = 930' 'viscosity_mPa_s = 9.3' >> scene.toml
    done
}

# clears a terminal, ends a line, turns the direction, hides, and is markup wherever it goes
HOSTILE=$'\e[2J\e]0;x\a\r\n\xe2\x80\xae<img src=x onerror=alert(1)> ![a](b) `c` **d** | \xe2\x80\x8b\xc2\x9b0m\xe2\x80\xa8&lt;'
# simulates a scene of PTFE in two liquids: its diameters, film ratios, heights, dry speeds and repeats, and more lines
simulated() {
    rm -f runs.csv
    printf '%s\n' '[data]' 'runs = "runs.csv"' '[particles.PTFE]' 'density_kg_m3 = 2150' 'roughness_um = 5' \
        '[liquids.AK10]' 'density_kg_m3 = 930' 'viscosity_mPa_s = 9.3' '[liquids.M50]' 'density_kg_m3 = 965' \
        'viscosity_mPa_s = 48.3' '[model]' 'inertia = "saturating"' '[truth]' 'dry_k = { PTFE = 0.183 }' \
        'lubrication_log = 1.85' 'inertia = "saturating"' 'inertial_prefactor = 0.47' 'film_scale = 0.069' \
        'sigma_dry = 0.009' 'sigma_wet = 0.02' '[design]' "diameter_mm = { PTFE = [$1] }" 'liquids = ["AK10", "M50"]' \
        "film_ratio = { PTFE = [$2] }" "height_mm = [$3]" "dry_impact_speed_m_s = [$4]" "repeats = $5" "${@:6}" > scene.toml
    wetcor simulate scene.toml --out runs.csv
}
# runs of many diameters or film ratios, one of each of two liquids
crowded() { simulated "$1" "$2" 150 '0.5, 1.0, 1.5' 2; }
# what is said, drawn and written of so many series is bounded
readable() {
    wetcor fit scene.toml --out out --stages least_squares,figures > told.txt && test "$(wc -l < told.txt)" -lt 40 || return
    wetcor check scene.toml > told.txt; test "$(wc -l < told.txt)" -lt 100 || return
    awk '/^[|]/ { rows++; if (rows > 62) exit 1; next } { rows = 0 }' out/report.md || return
    grep -qF "The first 60 of $1 rows; findings.json has all." out/report.md || return
    for figure in out/figures/*; do
        test "$(wc -c < "$figure")" -lt 300000 || return
        grep -o 'height="[0-9.]*' "$figure" | head -n 1 | awk -F '"' '{ exit $2 >= 800 }' || return
    done
}
# two particles of two diameters each, each of which has a k of its own
diameters() {
    printf '%s\n' '[data]' 'runs = "runs.csv"' '[particles.PTFE]' 'density_kg_m3 = 2150' 'roughness_um = 5' \
        '[particles.PE]' 'density_kg_m3 = 940' 'roughness_um = 5' '[liquids.AK10]' 'density_kg_m3 = 930' \
        'viscosity_mPa_s = 9.3' '[liquids.M20]' 'density_kg_m3 = 930' 'viscosity_mPa_s = 20' '[model]' \
        'dry_k = "diameter"' '[sampler]' 'chains = 2' 'warmup = 400' 'draws = 800' '[bootstrap]' 'replicates = 200' \
        '[truth]' 'lubrication_log = 1.85' 'inertial_prefactor = 0.6' 'sigma_dry = 0.009' 'sigma_wet = 0.02' \
        'dry_k = { PTFE = { "4.762" = 0.175, "8" = 0.190 }, PE = { "4.762" = 0.117, "7.938" = 0.129 } }' '[design]' \
        'diameter_mm = { PTFE = [4.762, 8], PE = [4.762, 7.938] }' 'liquids = ["AK10", "M20"]' \
        'film_ratio = { PTFE = [0.03, 0.06, 0.12], PE = [0.03, 0.05, 0.08] }' 'height_mm = [60, 80, 100, 125, 150]' \
        'dry_impact_speed_m_s = [0.5, 1.0, 2.0]' 'repeats = 5'
}
# the restitution that is predicted of PTFE at 1.5 m/s
restitution() {
    wetcor predict r --particle PTFE --diameter-mm "$1" --film-um "$2" --liquid AK10 --speed-m-s 1.5:1.5:1 | sed -n 2p | cut -d , -f 4
}
near() { awk -v a="$1" -v most="$2" -v b="$3" 'BEGIN { exit !(b != "" && (a - b)^2 < most^2) }'; }
# a fit and a check of the plain example with this model and these of its rows print and write no number that is none; in the
# figures of the page `inf` is a subscript
dashes() {
    { cat "$PLAIN/scene.toml"; briefest; echo '[model]'; echo "$1"; } > scene.toml
    awk -F , -v OFS=, "$2" "$PLAIN/runs.csv" > runs.csv
    rm -rf report
    wetcor fit scene.toml --stages least_squares,bootstrap,posterior,figures --out report > told.txt 2>&1
    test $? -le 2 && wetcor check scene.toml >> told.txt 2>&1
    test $? -le 2 || return
    ! cat told.txt report/report.md report/report.html 2> /dev/null | sed 's/>inf</></g' | grep -wE 'NaN|inf|infinity|panicked'
}
# a title, sources and a column that nobody should write
hostile() {
    local told='"\u001b[2J\u001b]0;x\u0007\r\n\u202e<img src=x onerror=alert(1)> ![a](b) `c` **d** | \u200b\u009b0m\u2028&lt;"'
    printf '%s\n' "title = $told" "source = $told" "$(tail -n +2 "$PLAIN/scene.toml")" '[[published]]' 'quantity = "dry_k"' \
        'particle = "PTFE"' 'value = 0.183' 'se = 0.001' "source = $told" "$(brief)" > scene.toml
    echo "$(header),$(printf %s "$HOSTILE" | tr -d '\r\n,"')" > runs.csv
    tail -n +2 "$PLAIN/runs.csv" | sed 's/$/,1/' >> runs.csv
}
# no file of text in a folder moves a terminal, or turns or hides text
harmless() {
    ! LC_ALL=C grep -rlP '[\x01-\x09\x0b-\x1f\x7f]|\xc2[\x80-\x9f]|\xd8\x9c|\xe2\x80[\x8b\x8e\x8f\xa8-\xae]|\xe2\x81[\xa6-\xa9]|\xef\xbb\xbf' \
        --include=*.md --include=*.html --include=*.json --include=*.svg --include=*.csv "$1"
}
# the verbs that the help lists, and the long flags of one
verbs() { wetcor --help | awk '/^Commands:/ { on = 1; next } /^[^ ]/ { on = 0 } on && /^  [a-z]/ { print $1 }'; }
flags() { wetcor $1 --help | grep -oE '^ +(-[a-zA-Z], )?--[a-zA-Z0-9-]+' | grep -oE -- '--.*' | sort -u; }
# the script of a shell names every verb and flag, of which fish writes no dashes, and no character as an escape
completes() {
    wetcor completions "$1" > script || return
    for word in $(verbs) $(for verb in '' $(verbs); do flags "$verb"; done); do
        grep -qF -- "${word#--}" script || { echo "$1: $word" >&2; return 1; }
    done
    ! grep -F '\u{' script
}
# the manual page of a verb, or of wetcor itself, has its name and its flags
page_of() {
    local name=wetcor${1:+-$1}
    wetcor man $1 | sed 's/\\f[BIR]//g; s/\\-/-/g' > page
    grep -q "^\.TH $name 1 " page && grep -q "^$name - " page || return
    for flag in $(flags "$1"); do
        grep -qE -- "^ *(-[a-zA-Z], )?$flag" page || { echo "$name: $flag" >&2; return 1; }
    done
}

# dry rebounds of a sphere of this k from some heights, all of them so much higher: a table without its header
rebounds() {
    seq 0 23 | awk -v k="$1" -v above="${2:-0}" '{ h = 20 + 12 * int($1 / 3); split("-0.006 0.001 0.005", noise, " ")
        e = 1 - k * sqrt(2 * 9.81 * h / 1000)^0.2 + noise[$1 % 3 + 1]
        printf "PTFE,4.762,%s,%.3f\n", h + above, e * e * h + above }'
}
HEIGHTS=particle,diameter_mm,drop_height_mm,rebound_height_mm
# the same as a sheet, with its name and marks
sheet() { echo "== $1"; echo $HEIGHTS; rebounds "$2" $3; }
# a scene of them: the table or tables, and lines of [data]
of_heights() { printf '%s\n' '[data]' "runs = $1" "${@:2}" '[particles.PTFE]' 'density_kg_m3 = 2150' > scene.toml; }

# a prediction of the example's sphere, or of another folder's; without speeds the same sphere
SPHERE='--particle PTFE --liquid AK10 --diameter-mm 4.762 --film-um 286'
asked() { wetcor predict "$1" $SPHERE --speed-m-s 0.05:2:6 "${@:2}"; }
# a folder `r` with two draws, as small as one can be, whose findings these commands of sed change
store() {
    mkdir -p r
    sed "${@:-}" > r/findings.json <<END
{"schema":"wetcor.findings/3","title":"t","wetcor":"$(wetcor --version | cut -d ' ' -f 2)","remarks":[],"posterior":{
"left_out":[{"name":"dry_k[PE]","value":null,"reason":"no runs"}],"terms":["inertia","viscous"],"inertia":"stepwise","viscous":"constant","dry_speed_m_s":2.0,
"basis":{"smallest_restitution":0.0,"particles":[{"name":"PTFE","density_kg_m3":2150.0,"roughness_m":5e-6,"covered":null},
{"name":"PE","density_kg_m3":940.0,"roughness_m":5e-6,"covered":null}],"liquids":[{"name":"AK10","density_kg_m3":930.0,"viscosity_Pa_s":0.0093}],
"draws":[{"name":"dry_k[PTFE]","values":[0.183,0.184]},{"name":"lubrication_log","values":[1.85,1.86]},
{"name":"inertial_prefactor","values":[0.9,0.8]},{"name":"sigma_dry","values":[0.01,0.01]},{"name":"sigma_wet","values":[0.02,0.02]}]}}}
END
}
# the same with remarks, each a code, a level and a text
store_with() {
    local all=
    for remark in "$@"; do
        IFS='|' read -r code level text <<< "$remark"
        all="$all,{\"code\":\"$code\",\"level\":\"$level\",\"passed\":false,\"text\":\"$text\",\"next_step\":\"\"}"
    done
    store "s/\"remarks\":\[\]/\"remarks\":[${all#,}]/"
}
# the restitution of a row of predictions
restitution_of() { sed -n "$2" "$1" | cut -d , -f 4; }

# the example with lines of its scene changed by sed, and cells of its table by awk, without the screen of thin films
example() {
    rm -f scene.toml runs.csv
    sed "s/^min_film_um/# &/; $1" "$PROJECT/datasets/mueller2016/scene.toml" > scene.toml
    awk -F , -v OFS=, "NR == 1 { print; next } ${2:-1}" "$PROJECT/datasets/mueller2016/runs.csv" > runs.csv
}

# runs of two diameters and three films, sampled briefly
reported() {
    simulated '3.175, 8.0' '0.04, 0.08, 0.15' '30, 60, 90, 120, 150' '0.4, 0.8, 1.2, 1.6, 2.0' 4 \
        '[sampler]' 'chains = 2' 'warmup = 200' 'draws = 200'
}

# a fit under a seed; its report without times and what the command was
seeded() { wetcor fit scene.toml --stages least_squares,figures --seed $1 --out "$2" > told$1.txt 2>&1; test $? -le 1; }
timeless() { rm "$1/timing.json" && sed -i 's| --seed [12]||; s| --out [^ `<&"]*||' "$1/report.md" "$1/report.html"; }
# of two fits at once into one folder, of which there are `one` and `two`, one stands whole, and nothing else is left
at_once() {
    seeded 1 $1 & local first=$!
    seeded 2 $1 & wait $! && wait $first || return
    test "$(ls -A $1/.. $1/../.. $1/../../.. | grep -v : | xargs)" = 'report fits of' || return
    timeless $1 && { diff -r one $1 > told1.txt || diff -r two $1 > told1.txt; }
}
# a number of a row of predictions by the name of its column
cell() { awk -F , -v name="$2" -v row="${3:-2}" 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == name) at = i } NR == row { print $at }' "$1"; }
# runs of 18 series, each of which has an offset of its own
series() {
    printf '%s\n' '[data]' 'runs = "runs.csv"' '[particles.PTFE]' 'density_kg_m3 = 2150' 'roughness_um = 5' '[liquids.thin]' \
        'density_kg_m3 = 930' 'viscosity_mPa_s = 9.3' '[liquids.thick]' 'density_kg_m3 = 960' 'viscosity_mPa_s = 20' \
        '[model]' 'inertia = "stepwise"' 'series_offsets = true' '[sampler]' 'chains = 2' 'warmup = 200' 'draws = 200' '[truth]' \
        'dry_k = { PTFE = 0.183 }' 'lubrication_log = 1.85' 'inertial_prefactor = 1.2' 'sigma_dry = 0.01' 'sigma_wet = 0.02' \
        'sigma_series = 0.02' '[design]' 'diameter_mm = { PTFE = [3.175, 4.762, 8.0] }' 'liquids = ["thin", "thick"]' \
        'film_ratio = { PTFE = [0.04, 0.07, 0.1] }' 'height_mm = [30, 60, 90, 120, 150]' \
        'dry_impact_speed_m_s = [0.4, 0.8, 1.2, 1.6, 2.0]' 'repeats = 5' > scene.toml
    rm -f runs.csv; wetcor simulate scene.toml --out runs.csv --seed 3
}
# two particles of different roughness whose viscous loss is that of the whole film
whole_film() {
    printf '%s\n' '[data]' 'runs = "runs.csv"' '[particles.PTFE]' 'density_kg_m3 = 2150' 'roughness_um = 5' '[particles.PE]' \
        'density_kg_m3 = 940' 'roughness_um = 12' '[liquids.AK10]' 'density_kg_m3 = 930' 'viscosity_mPa_s = 9.3' '[model]' \
        'inertia = "stepwise"' 'viscous = "film"' '[sampler]' 'chains = 2' 'warmup = 400' 'draws = 800' '[truth]' \
        'dry_k = { PTFE = 0.183, PE = 0.12 }' 'viscous = "film"' 'rupture_scale = 0.9' 'inertial_prefactor = 0.5' \
        'sigma_dry = 0.01' 'sigma_wet = 0.01' '[design]' 'diameter_mm = { PTFE = [3, 6], PE = [5] }' 'liquids = ["AK10"]' \
        'film_ratio = { PTFE = [0.03, 0.06, 0.12], PE = [0.05, 0.10] }' 'impact_speed_m_s = [0.8, 1.0, 1.3, 1.7, 2.2]' \
        'dry_impact_speed_m_s = [0.5, 0.8, 1.2, 1.6, 2.0]' 'repeats = 2' > scene.toml
    rm runs.csv; wetcor simulate scene.toml --out runs.csv
}
# a scene whose spreads are held at 0, and drawn runs that err as they state
stated() {
    printf '%s\n' '[data]' 'runs = "runs.csv"' '[particles.PTFE]' 'density_kg_m3 = 2150' 'roughness_um = 5' '[liquids.thin]' \
        'density_kg_m3 = 930' 'viscosity_mPa_s = 9.3' '[model]' 'inertia = "stepwise"' '[priors]' 'sigma_dry = { fixed = 0 }' \
        'sigma_wet = { fixed = 0 }' '[sampler]' 'warmup = 300' 'draws = 300' '[bootstrap]' 'replicates = 200' '[truth]' \
        'dry_k = { PTFE = 0.183 }' 'lubrication_log = 1.85' 'inertial_prefactor = 1.0' 'sigma_dry = 0.01' 'sigma_wet = 0.01' \
        '[design]' 'diameter_mm = { PTFE = [4.762] }' 'liquids = ["thin"]' 'film_ratio = { PTFE = [0.04, 0.1] }' \
        'height_mm = [30, 60, 100, 150]' 'dry_impact_speed_m_s = [0.4, 0.8, 1.2, 1.6, 2.0]' 'repeats = 4' > scene.toml
    rm runs.csv; wetcor simulate scene.toml --out drawn.csv && sed '1s/$/,restitution_sd/; 2,$s/$/,0.01/' drawn.csv > runs.csv
}

# a scene of one sphere in two liquids, whose lines of [data] these are; its runs are read from the standard input and fitted
rows() {
    printf '%s\n' '[data]' 'runs = "runs.csv"' "$@" '[particles.PTFE]' 'density_kg_m3 = 2150' '[liquids.thin]' 'density_kg_m3 = 930' \
        'viscosity_mPa_s = 9.3' '[liquids.thick]' 'density_kg_m3 = 960' 'viscosity_mPa_s = 20' '[model]' 'inertia = "stepwise"' > scene.toml
    cat > runs.csv
    fit out --verbose > told.txt 2>&1
    test $? -le 1
}
# that no remark of a code failed; that one did, with all of these words
none() { count out "remarks[code=$1,passed=false]" = 0; }
one() {
    count out "remarks[code=$1,passed=false]" = 1 || return
    for words in "${@:2}"; do field out "remarks[code=$1,passed=false].text" has "$words" || return; done
}
# columns that contradict each other, which forbids quoting
contradict() { one columns_agree "$@" && field out 'remarks[code=columns_agree,passed=false].level' = forbids; }
agree() { none columns_agree; }

COLUMNS=particle,liquid,diameter_mm,film_um,impact_speed_m_s,restitution
# a table of so many runs; the expressions of awk say what is in a row, from the number `run` of it and from `v` and `e`
table() {
    echo "$COLUMNS,$1"
    seq 0 $(($2 - 1)) | awk 'function round(x) { return int(x + 0.5) } { run = $1; liquid = "dry"; film = ""; '"$3"'; print "PTFE",
        liquid, 4.762, film, sprintf("%.4f", v), sprintf("%.4f", e), more }' OFS=,
}
# runs with a column of film ratios, which an expression gives from the film's `own`; films about two values, each its own
ratios() {
    table film_ratio 120 "liquid = \"thin\"; own = $1; film = sprintf(\"%.12g\", 4762 * own); v = 0.5 + 0.011 * run
        e = 1 - 0.18 * v^0.2 - 0.06 / v + 0.01 * ((11 * run) % 17) / 17; more = sprintf(\"%.5f\", $2)"
}
own_films() { ratios '(run % 2 ? 0.08 : 0.05) * (1 + 0.0005 * ((37 * run) % 101))' "$1"; }
# dry runs in blocks of three, and after each what an expression gives of the block's `speed`
blocks() {
    echo trial,particle,liquid,diameter_mm,impact_speed_m_s,restitution,remark
    seq 0 11 | awk '{ split("11 -14 4 -9 12 -5 3 -2 13 -12 6 -7", off, " "); speed = 0.6 + 0.45 * int($1 / 3); v = speed + 0.003 * ($1 % 3)
        printf "%d,PTFE,dry,4.762,%.3f,%.3f,\n", $1 + 1, v, 1 - 0.18 * v^0.2 + off[$1 + 1] / 1000; after = '"${1:-\"\"}"'
        if (after != "" && $1 % 3 == 2) print after }'
}

# so many dry and wet runs of one particle, other rows, and lines of a scene that samples them briefly
few() {
    { echo "$COLUMNS"
      printf 'PTFE,dry,4.762,,%s\n' 1,0.818 2,0.789 1.4,0.811 0.6,0.835 | head -n "$1"
      printf 'PTFE,AK10,4.762,286,%s\n' 0.9,0.642 1.7,0.681 1.3,0.66 1.5,0.67 1.1,0.66 0.7,0.61 | head -n "$2"; } > runs.csv
    printf '%s\n' '[data]' 'runs = "runs.csv"' '[particles.PTFE]' 'density_kg_m3 = 2150' 'roughness_um = 5' '[particles.PE]' \
        'density_kg_m3 = 940' 'roughness_um = 5' '[liquids.AK10]' 'density_kg_m3 = 930' 'viscosity_mPa_s = 9.3' '[sampler]' \
        'chains = 2' 'warmup = 200' 'draws = 100' "${@:3}" > scene.toml
}
# whether they are sampled; that they are refused with these words
is_sampled() {
    wetcor fit scene.toml --stages least_squares,posterior --out out > told.txt 2>&1
    test $? -le 1 && field out posterior != null && none runs_to_spare
}
is_refused() {
    wetcor fit scene.toml --stages least_squares,posterior --out out > told.txt 2>&1
    test $? = 1 && field out posterior = null && one "$1" "$2"
}

# rebounds of one series of the plain example's liquid or another about its square-root law; runs of one at one speed
rebounding() {
    seq 0 $(($4 - 1)) | awk -v liquid=$1 -v alpha=$2 -v beta=$3 '{ v = 0.9 + 0.1 * int($1 / 2)
        printf "PTFE,%s,4.762,286,0.06,%.2f,%.4f\n", liquid, v, sqrt(alpha + beta / v) + 0.01 * sin(3 * $1) }'
}
at_speed() { seq 0 11 | awk -v liquid=$1 -v v=$2 -v e=$3 '{ printf "PTFE,%s,4.762,286,0.06,%s,%.4f\n", liquid, v, e + 0.01 * ($1 % 3 - 1) }'; }
# fits such rows from the standard input, resampled by a scheme
resample() {
    printf '%s\n' '[data]' 'runs = "runs.csv"' '[particles.PTFE]' 'density_kg_m3 = 2150' 'roughness_um = 5' '[liquids.AK10]' \
        'density_kg_m3 = 930' 'viscosity_mPa_s = 9.3' '[liquids.M20]' 'density_kg_m3 = 930' 'viscosity_mPa_s = 20' '[bootstrap]' \
        "scheme = \"$1\"" 'replicates = 500' > scene.toml
    { header; cat; } > runs.csv
    wetcor fit scene.toml --stages least_squares,bootstrap --out out > told.txt 2>&1
    test $? -le 1
}

# positions of a sphere that falls and rebounds, frame by frame at 1000 Hz: an expression of awk gives its row from the height `h`
FILMED=file,particle,liquid,diameter_mm,film_um,frame_rate_Hz
falling() {
    echo frame,y_px
    seq 0 599 | awk '{ g = 9.81; before = 0.06 - $1 / 1000; if (before > 1.2 / g) before = 1.2 / g
        if (before >= 0) h = 1.2 * before - g / 2 * before^2
        else { start = 0; v = 0.7 * 1.2
            while (v > 1e-6 && -before >= start + 2 * v / g) { start += 2 * v / g; v *= 0.7 }
            h = v * (-before - start) - g / 2 * (-before - start)^2; if (h < 0) h = 0 }
        printf "%d,%.6f\n", $1, '"$1"' }'
}
# a list of recordings
filmed() { { echo $FILMED; for file in "$@"; do echo $file.csv,PTFE,dry,4.762,,1000; done; } > recordings.csv; }

# runs about the threshold of rebound: wet ones from the standard input, beside dry ones
threshold() {
    printf '%s\n' '[data]' 'runs = "runs.csv"' '[particles.PTFE]' 'density_kg_m3 = 2150' 'roughness_um = 5' '[liquids.M50]' \
        'density_kg_m3 = 965' 'viscosity_mPa_s = 48.3' '[model]' 'inertia = "stepwise"' '[bootstrap]' 'replicates = 500' > scene.toml
    { echo $COLUMNS; printf 'PTFE,dry,4.762,,%s\n' 0.5,0.842 0.5,0.835 1,0.812 1,0.823 2,0.795 2,0.785
      printf 'PTFE,M50,4.762,380.96,%s\n' "$@"; } > runs.csv
}
# a design in which every term of the energy balance acts: the terms of the model, changed by sed; and its fit
terms() {
    rm -f runs.csv
    printf '%s\n' '[data]' 'runs = "runs.csv"' '[particles.P]' 'density_kg_m3 = 2150' 'roughness_um = 5' '[liquids.oil]' \
        'density_kg_m3 = 930' 'viscosity_mPa_s = 9.3' 'surface_tension_mN_m = 20.1' '[model]' 'inertia = "stepwise"' "terms = $1" \
        'dry_speed_m_s = 2.0' '[truth]' 'dry_k = { P = 0.15 }' 'lubrication_log = 3.0' 'inertial_prefactor = 1.0' \
        'sigma_dry = 0.01' 'sigma_wet = 0.02' 'dry_speed_m_s = 2.0' 'terms = ["inertia", "viscous"]' '[design]' \
        'diameter_mm = { P = [6.0] }' 'liquids = ["oil"]' 'film_ratio = { P = [0.05, 0.1] }' \
        'impact_speed_m_s = [0.9, 1.2, 1.6, 2.2]' \
        'dry_impact_speed_m_s = [0.5, 0.7, 0.9, 1.1, 1.3, 1.5, 1.7, 1.9, 2.1, 2.3, 2.5, 2.7]' 'repeats = 20' | sed "$2" > scene.toml
    wetcor simulate scene.toml --out runs.csv && fit out > told.txt 2>&1
    test $? -le 1
}
# whether the terms of a list are held
held() { for term in "${@:2}"; do field out "terms[term=$term].held" = $1 || return; done; }
# whether the energy balance has estimates of each quantity of a list
of_balance() {
    for quantity in "${@:2}"; do count out "estimates[quantity=$quantity,source=energy_balance]" $1 0 || return; done
}
