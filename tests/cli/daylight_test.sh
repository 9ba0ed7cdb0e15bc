# Daylight coefficients, gradients and powers of lamps of a saved transport.
. "$(dirname "$0")/lib.sh"

size="--sites 200 --rays 32 --error-points 0"
if [ $sanitized = yes ]; then
    size="--sites 60 --rays 16 --error-points 0"
fi
expect_exit 0 "$bake" "$DIFUSA_DATA/office.json" office.vtp $size --save-transport office.difusa
printf '2.8,1.95,0.75,0,0,1\n1.0,1.0,0.75,0,0,1\n4.5,3.0,0.75,0,0,1\n' >desks.csv

# Coefficients, and their product with skies: at once, and from the file.
overcast="cie:type=16,illuminance=10000"
expect_exit 0 "$relight" office.difusa --daylight c.mtx --at desks.csv --daylight-rays 600 --daylight-sky $overcast \
    --daylight-output at_once.csv
expect_text stdout "written: c.mtx (3 points, 146 parts" "written: at_once.csv" "sky: cie:type=16"
expect_text c.mtx "NROWS=3" "NCOLS=146" "FORMAT=ascii" "SKY_DIVISION= MF:1"
[ "$(head -n 1 c.mtx)" = "#?RADIANCE" ] || fail "the first line is not Radiance's"
expect_exit 0 "$relight" --daylight-from c.mtx --daylight-sky $overcast --daylight-output later.csv
awk -F, 'NR == FNR { lux[NR] = $11; next }
         FNR > 1 && !($11 > 0 && ($11 - lux[FNR]) ^ 2 < (1e-6 * $11) ^ 2) { bad = 1 }
         END { exit bad || FNR != 4 }' at_once.csv later.csv || fail "the product differs: $(cat at_once.csv later.csv)"
cp c.mtx c.copy
expect_exit 0 "$relight" office.difusa --daylight c.mtx --at desks.csv --daylight-rays 600 --threads 3 --quiet
cmp c.mtx c.copy || fail "coefficients depend on the number of threads"
expect_exit 0 "$relight" --daylight-from c.mtx --daylight-sky perez:direct=600,diffuse=150,elevation=30,azimuth=120 \
    --daylight-output perez.csv
expect_text stdout "sun=part adds it"

# NumPy's, of the output vertices, with a north of their own.
expect_exit 0 "$relight" office.difusa --daylight c.npz --output-spacing 2 --daylight-rays 100 --north 1,0,0
if command -v python3 >/dev/null; then
    python3 -c 'import zipfile
z = zipfile.ZipFile("c.npz")
assert z.testzip() is None
assert {"red.npy", "green.npy", "blue.npy", "illuminance.npy", "position.npy"} <= set(z.namelist()), z.namelist()' ||
        fail "c.npz is not what it should be"
fi

# Gradients.
printf '{"goals": [{"name": "desk", "places": [[2.8, 1.95, 0.0, 0, 0, 1]]}]}\n' >goals.json
expect_exit 0 "$relight" office.difusa --gradients g.csv --goal goals.json
expect_text g.csv 'goal,kind,name,value_r' '"desk",mean,""' '"desk",group,"luminaires",1,1,1' '"desk",group,"sky"' \
    '"desk",reflectance,'

# Lamps: 500 lux, and brighter lamps than before take a smaller factor.
expect_exit 0 "$relight" office.difusa even.ply --error-points 0 --at desks.csv --at-output even.csv --solve-lamps 500 \
    --scale sky=0
expect_text stdout "lamps: luminaires x " "for 500 lux at 3 places"
expect_exit 0 "$relight" office.difusa even.ply --error-points 0 --at desks.csv --solve-lamps 500 --report even.json
expect_text even.json '"light_group": "luminaires"' '"factor": '


# Refused, without a trace.
usage() { # usage TEXT ARGUMENT...
    local text=$1
    shift
    expect_refusal 1 "$text" "$relight" "$@"
}
usage "no field is written: omit it" office.difusa out.vtp --daylight c2.mtx
usage "must end in .mtx (Radiance) or .npz" office.difusa --daylight c2.csv
usage "must be one of cie, perez" office.difusa --daylight c2.mtx --daylight-sky bogus:1 --daylight-output x.csv
usage "go together" office.difusa --daylight c2.mtx --daylight-sky $overcast
usage "needs a sky" --daylight-from c.mtx
usage "needs no transport" office.difusa --daylight-from c.mtx --daylight-sky $overcast --daylight-output x.csv
usage "would overwrite the coefficients" --daylight-from c.mtx --daylight-sky $overcast --daylight-output c.mtx
usage "did you mean cie" --daylight-from c.mtx --daylight-sky cje:type=1 --daylight-output x.csv
usage "must be at most 16" office.difusa --daylight c2.mtx --sky-parts 17
usage "daylight coefficients are those of planes" office.difusa --daylight c2.mtx --grid 0:spacing=0.5,height=1 \
    --sensor spherical
usage "--goal: has no effect on daylight coefficients" office.difusa --daylight c2.mtx --goal goals.json
usage "--final-gather: has no effect where no field is evaluated" office.difusa --daylight c2.mtx --final-gather 8
usage "--sky-parts: has no effect without --daylight" office.difusa out.vtp --sky-parts 2
usage "needs goals" office.difusa --gradients g2.csv
usage "needs places" office.difusa out.vtp --solve-lamps 500
usage "cannot be combined" office.difusa out.pvd --solve-lamps 500 --sun-path 48,11,2026-06-21
usage "the level must be above 0, and at most 1e30" office.difusa out.vtp --at desks.csv --solve-lamps 1e160
sed -e '$s/^[0-9.e+-]*/-1/' c.copy >negative.mtx
expect_refusal 2 "negative.mtx:$(wc -l <negative.mtx): a coefficient must be finite, and not negative" "$relight" \
    --daylight-from negative.mtx --daylight-sky $overcast --daylight-output x.csv
expect_refusal 2 "#?RADIANCE" "$relight" --daylight-from desks.csv --daylight-sky $overcast --daylight-output x.csv
