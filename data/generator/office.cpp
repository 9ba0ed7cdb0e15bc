#include "scenes.h"

namespace scenes {

std::string office_luminaire_ies() {
    return "IESNA:LM-63-2002\n"
           "[TEST] made up for this project, data/generator/office.cpp: no luminaire was measured\n"
           "[MANUFAC] none\n"
           "[LUMINAIRE] surface-mounted, 1.2 m by 0.3 m, with a prismatic cover\n"
           "[LAMP] LED, 3311 lm from the luminaire (absolute photometry)\n"
           "TILT=NONE\n"
           "1 -1 1 10 3 1 2 0.3 1.2 0\n"
           "1 1 32\n"
           "0 10 20 30 40 50 60 70 80 90\n"
           "0 45 90\n"
           "1150 1160 1170 1130 1000 780 500 230 60 0\n"
           "1150 1145 1125 1060 930 735 490 240 70 0\n"
           "1150 1130 1080 990 860 690 480 250 80 0\n";
}

std::string office_json() {
    return R"({
  "difusa_scene": 1,
  "comment": "The room of room.off with two luminaires on its ceiling, under an overcast sky. Made up for this project by data/generator/office.cpp.",
  "unit": "m",
  "meshes": [{"file": "room.off"}],
  "lights": [
    {"type": "luminaire", "name": "luminaires", "file": "office_luminaire.ies", "as": "area", "position": [1.8, 2.1, 2.69]},
    {"type": "luminaire", "name": "luminaires", "file": "office_luminaire.ies", "as": "area", "position": [3.6, 2.1, 2.69]}
  ],
  "sky": {"type": "cie", "sky": "overcast", "illuminance": 5000, "ground_reflectance": 0.2},
  "camera": {"eye": [5.1, 0.35, 1.7], "look_at": [1.6, 2.9, 1.15], "view_degrees": 62}
}
)";
}

} // namespace scenes
