# render_view makes pictures of a bake without a display, and refuses what is wrong before the work.
. "$(dirname "$0")/lib.sh"
render=$DIFUSA_BIN/render_view
unset DISPLAY

refuse() { # refuse CODE TEXT ARGUMENT...
    local code=$1 text=$2
    shift 2
    expect_refusal "$code" "$text" "$render" "$@"
}

# Wrong command lines.
refuse 1 "a scene or mesh file is expected"
refuse 1 "a picture file is expected" "$box"
refuse 1 "\`third\` is one argument too many" "$box" out.png third
refuse 1 "unknown option --sampels, did you mean --samples?" "$box" out.png --sampels 4
refuse 1 "--show radiosty: unknown, did you mean radiosity?" "$box" out.png --show radiosty
refuse 1 "--also direct.png: takes SHOW=FILE" "$box" out.png --also direct.png
refuse 1 "did you mean direct?" "$box" out.png --also dirrect=direct.png
refuse 1 "did you mean 'shepard'?" "$box" out.png --basis shepherd
refuse 1 "did you mean 'disc'?" "$box" out.png --kernel disk
refuse 1 "out.jpg: a picture's name ends in .png or" "$box" out.jpg
refuse 1 "out.tiff: a picture's name ends in .png or" "$box" out.png --also sites=out.tiff
refuse 1 "--samples 5: must be a square number" "$box" out.png --samples 5
refuse 1 "--size 0: must be a whole number of at least 1" "$box" out.png --size 0 10
refuse 1 "--size: width and height must be from 1 to 32768" "$box" out.png --size 10 32769
refuse 1 "--view-angle 180: must be below 180" "$box" out.png --view-angle 180
refuse 1 "takes three numbers X,Y,Z" "$box" out.png --eye 1,2
refuse 1 "--up 0,0,0: must be a nonzero direction" "$box" out.png --up 0,0,0
refuse 1 "--exposure 0: must be a positive number" "$box" out.png --exposure 0
refuse 1 "--background 2,0,0: must be from 0 to 1 in each channel" "$box" out.png --background 2,0,0
refuse 1 "--exposure: no picture is exposed" "$box" out.hdr --exposure 2
refuse 1 "--show basis in out.hdr: there are negative values" "$box" out.hdr --show basis
refuse 1 "--show sites in b.hdr: the dots are drawn in .png" "$box" out.png --also sites=b.hdr
refuse 1 "--tone: no picture is exposed" "$box" out.png --show illuminance --tone linear
refuse 1 "--tone flimic: must be linear or filmic" "$box" out.png --tone flimic
refuse 1 "--range 2,1: takes LOW,HIGH" "$box" out.png --show luminance --range 2,1
refuse 1 "--range: no picture has a colour bar" "$box" out.png --range 1,2
refuse 1 "--log: no picture has a colour bar" "$box" out.png --log
refuse 1 "--range: must begin above 0" "$box" out.png --show luminance --range 0,2 --log
refuse 1 "--element: only valid with --show basis" "$box" out.png --element 3
refuse 1 "--near: only valid with --show basis" "$box" out.png --near 1,2,3
refuse 1 "--element and --near both" "$box" out.png --show basis --element 3 --near 1,2,3
refuse 1 "two outputs have this name" "$box" out.png --also direct=./out.png
refuse 1 "two outputs have this name" "$box" out.png --report out.png
refuse 1 "--at places.csv: the results need an output file" "$box" out.png --at places.csv
refuse 2 "no-such.off" no-such.off out.png
refuse 4 "no-such-directory" "$box" out.png --also sites=no-such-directory/sites.png
cp "$box" scene.png
refuse 1 "would overwrite the scene" scene.png scene.png
rm scene.png
# What only the bake can tell leaves no picture either.
refuse 1 "there is no such element; they are numbered from 0 to" "$box" out.png $small --show basis --element 9999
refuse 1 "there is no such light group; there are" "$box" out.png $small --show group:sun
refuse 1 "--show error: there is no error estimate" "$box" out.png $small --show error --error-points 0
refuse 1 "--look-at and --towards both" "$box" out.png --look-at 0,0,0 --towards 0,0,1
refuse 1 "the camera looks along --up" "$box" out.png $small --towards 0,1,0 --up 0,1,0
refuse 1 "the picture would show nothing: from (0.3, 0.3, -1) towards (0, 0, -1), no ray meets the surface" \
    "$box" out.png $small --eye 0.3,0.3,-1 --towards 0,0,-1

# Pictures of one bake; the same bits for any number of threads; other samples with another seed.
pictures="--also direct=direct.png --also indirect=indirect.png --also irradiance=irradiance.png
    --also irradiance-direct=a.png --also irradiance-indirect=b.png --also reflectance=c.png --also emission=d.png
    --also luminance=luminance.png --also error=error.png --also basis=basis.png --also sites=sites.png
    --also group:lamp=lamp.png --also radiosity=linear.hdr"
grep -q '^newmtl' "${box%.obj}.mtl" || fail "the box has materials"
lamp=$(awk '/^newmtl/ { name = $2 } /^Ke/ && $2 + $3 + $4 > 0 { print name; exit }' "${box%.obj}.mtl")
pictures=${pictures/group:lamp/group:$lamp}
view="--up 0,1,0 --size 40 30 --samples 4"
mkdir one two
# shellcheck disable=SC2086
(cd one && expect_exit 0 "$render" "$box" out.png $small $view $pictures --threads 1 --report report.json) || exit 1
# shellcheck disable=SC2086
(cd two && expect_exit 0 "$render" "$box" out.png $small $view $pictures --threads 3 --quiet) || exit 1
expect_text one/stdout "written: out.png (40 by 30, radiosity, exposure " "written: linear.hdr (40 by 30, radiosity, linear)" \
    "written: error.png (" " by 30, error, " "written: report.json" "error (rms, of the rms reflected radiosity): about"
[ ! -s two/stdout ] && [ ! -s two/stderr ] || fail "--quiet says something"
count=0
for picture in one/*.png one/*.hdr; do
    cmp -s "$picture" "two/${picture#one/}" || fail "$picture depends on the number of threads"
    count=$((count + 1))
done
[ "$count" = 14 ] || fail "$count pictures instead of 14"
[ "$(for picture in one/*.png; do cksum <"$picture"; done | sort -u | wc -l)" -ge 12 ] || fail "pictures are alike"
cmp -s one/out.png one/lamp.png || fail "the lamp gives all the light, yet the picture of its light differs"
expect_exit 0 "$render" "$box" out.png $small $view --seed 2 --quiet
if cmp -s out.png one/out.png; then
    fail "the seed has no effect"
fi
rm out.png

# PNG and Radiance are what they say, and their sizes are as asked for.
[ "$(head -c 8 one/out.png | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ] || fail "out.png is no PNG"
[ "$(od -An -tu1 -j 16 -N 8 one/out.png | tr -s ' \n' ' ')" = " 0 0 0 40 0 0 0 30 " ] ||
    [ "$(od -An -tu1 -j 16 -N 8 one/out.png | tr -s ' \n' ' ')" = " 0 0 0 40 0 0 0 30" ] || fail "another size"
expect_text one/linear.hdr "#?RADIANCE" "-Y 30 +X 40"

# Options of the picture have an effect; the default camera needs none.
expect_exit 0 "$render" "$box" plain.png $small --size 40 30
for options in "--tone linear" "--exposure 0.3" "--background 0,0,1" "--view-angle 20" "--eye 0.3,0.3,-1 --look-at 0.3,0.2,0.3 --up 0,1,0" \
    "--towards 0,0.1,-1 --up 0,1,0 --cull-backs" "--samples 1" "--final-gather 8"; do
    # shellcheck disable=SC2086
    expect_exit 0 "$render" "$box" other.png $small --size 40 30 $options
    if cmp -s plain.png other.png; then
        fail "$options has no effect"
    fi
done
for options in "--log" "--range 0.1,0.3"; do
    # shellcheck disable=SC2086
    expect_exit 0 "$render" "$box" other.png $small $view --show luminance $options
    if cmp -s one/luminance.png other.png; then
        fail "$options has no effect"
    fi
done
expect_exit 0 "$render" "$box" element.png $small $view --show basis --element 7
if cmp -s one/basis.png element.png; then
    fail "--element has no effect"
fi

# The element of the site at a place is that of the site's number.
expect_exit 0 "$render" "$box" near.png $small $view --show basis --near 0.3,0.2,0.5592
number=$(sed -n 's/^written: near.png .*element \([0-9]*\).*/\1/p' stdout)
expect_exit 0 "$render" "$box" numbered.png $small $view --show basis --element "$number" --quiet
cmp -s near.png numbered.png || fail "--near shows another element than it says"

# A saved transport is looked at from further places without baking again: what a bake would show there.
decided="--seed 7 --direct interpolated --solver jacobi"
# shellcheck disable=SC2086
{
    expect_exit 0 "$bake" "$box" box.ply $small $decided --save-transport box.difusa --quiet
    expect_exit 0 "$render" "$box" fresh.png $small $decided $view --eye 0.3,0.3,-1 --also error=fresh_error.png --quiet
}
expect_exit 0 "$render" box.difusa saved.png $view --eye 0.3,0.3,-1 --also error=saved_error.png --report saved.json
cmp -s fresh.png saved.png || fail "a saved transport does not look like its bake"
cmp -s fresh_error.png saved_error.png || fail "the error of a saved transport does not look like that of its bake"
expect_text saved.json '"what": "rays from the sites"'
expect_text saved.json '"direct": "interpolated"'
expect_text saved.json jacobi
expect_exit 0 "$render" box.difusa other.png $view --eye 0.3,0.3,-1 --sun 0,0.3,-1,5 --quiet
if cmp -s saved.png other.png; then
    fail "--sun does not light a saved transport"
fi
for option in "--sites 100" "--rays 8" "--basis shepard" "--quality draft" "--error 5%" "--adaptive" "--flip none" \
    "--seed 7"; do
    # shellcheck disable=SC2086
    refuse 1 "is a saved transport, for which this was decided when it was baked" box.difusa new.png $option
done
head -c 3000 box.difusa >cut.difusa
refuse 2 "cut.difusa: " cut.difusa new.png
: >empty.difusa
refuse 2 "empty.difusa: is empty" empty.difusa new.png
refuse 4 "memory has room for an output of 0" box.difusa new.png --max-memory 1MB

# What a picture shows against expectation is noted.
printf 'OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n' >floor.off
expect_exit 0 "$render" floor.off out.png --eye 0.5,0.4,-3 --look-at 0.5,0.5,0 --sites 100 --rays 16 --size 40 30
expect_text stdout "note: the picture shows mostly back faces"
expect_exit 0 "$render" floor.off out.png --reflectance 0 --sites 100 --rays 16 --size 40 30
expect_text stdout "note: nothing reflects or emits light"

# Nothing is half written: where one file cannot be, an older one stays and no other appears.
echo old >old.png
mkdir taken
expect_exit 1 "$render" "$box" old.png $small $view --also sites=taken
[ "$(cat old.png)" = old ] || fail "an older picture was touched"

expect_exit 0 "$render" --help
expect_text stdout "--show" "--also" "--eye" "--samples" "--basis" "--sun" "--seed" "Examples"
expect_exit 0 "$render" --version
expect_text stdout "render_view "
